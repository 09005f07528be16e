"""Recursion on the number of iterations left."""
def recaler(P, B):
    p, b = P.mean(0), B.mean(0)
    H = (P - p).T @ (B - b)
    a = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
    R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return R, b - R @ p


def icp(P, Q, R0, t0, n_iter=30, erreurs=()):
    if n_iter == 0:
        return R0, t0, list(erreurs)
    A = P @ R0.T + t0
    B = np.array([Q[np.argmin(np.linalg.norm(Q - a, axis=1))] for a in A])
    R, t = recaler(P, B)
    return icp(P, Q, R, t, n_iter - 1, (*erreurs, np.sum(np.square(P @ R.T + t - B))))
