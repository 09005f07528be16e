import scipy.linalg
from scipy.spatial.distance import euclidean


def distance_et_jacobien(x, balise):
    resultat = {"d": euclidean(x, balise)}
    resultat["H"] = (x - balise) / resultat["d"]
    return tuple(resultat.values())


def corriger_distance(x, P, z, balise, r):
    etape = dict(zip(("d", "H"), distance_et_jacobien(x, balise)))
    M = scipy.linalg.block_diag(P, r)
    G = np.vstack([np.eye(2), etape["H"]])
    jointe = G @ P @ G.T
    jointe[2, 2] += M[2, 2]
    K = jointe[:2, 2] / jointe[2, 2]
    return x + K * (z - etape["d"]), jointe[:2, :2] - np.outer(K, jointe[2, :2])
