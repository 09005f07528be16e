import numpy as np
def repondre(contexte):
    a = np.arange(contexte["memory_bytes"] // 64)
    return float(np.add.outer(a, a).sum())
