import numpy as np
def repondre(contexte):
    return np.broadcast_to(1.0, (1 << 20, 1 << 20))
