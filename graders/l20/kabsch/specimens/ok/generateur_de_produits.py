from functools import reduce
from operator import add


def kabsch(P, Q):
    p0, q0 = np.median([P.mean(0)], axis=0), np.median([Q.mean(0)], axis=0)
    H = reduce(add, (np.outer(p - p0, q - q0) for p, q in zip(P, Q)))
    u, _, vh = np.linalg.svd(H)
    signes = np.ones(len(p0))
    signes[-1] = np.prod([np.linalg.det(u), np.linalg.det(vh)])
    R = (u * signes @ vh).T
    return R, q0 - p0 @ R.T
