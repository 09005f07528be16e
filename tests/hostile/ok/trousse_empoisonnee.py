import sys, numpy as np, random
import outils
def repondre(contexte):
    outils.trame = outils.configurer = lambda *a, **k: {"np": None}
    np.random.seed(0)
    random.seed(0)
    np.seterr(all="raise")
    np.random.default_rng = lambda *a: None
    sys.setrecursionlimit(5000)
    return "rien"
