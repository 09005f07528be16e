# left: nodes
import numpy as np
def suivre():
    for k in range(500):
        M = np.full(400, float(k))
    return "rien"
