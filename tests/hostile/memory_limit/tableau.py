import numpy as np
def repondre(contexte):
    return float(np.ones(contexte["memory_bytes"] // 4).sum())
