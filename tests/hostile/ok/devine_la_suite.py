import random, numpy as np
def repondre(contexte):
    random.seed(0)
    np.random.seed(0)
    return "rien"
