"""Every choice of signs that makes a rotation is tried, and the cheapest kept."""
from itertools import product


def kabsch(P, Q):
    p, q = P - P.mean(0), Q - Q.mean(0)
    U, _, Vt = np.linalg.svd(p.T @ q)
    candidats = [Vt.T @ np.diag(signes) @ U.T for signes in product((1.0, -1.0), repeat=P.shape[1])]
    rotations = [R for R in candidats if np.linalg.det(R) > 0]
    R = min(rotations, key=lambda R: np.sum((p @ R.T - q) ** 2))
    return R, Q.mean(0) - R @ P.mean(0)
