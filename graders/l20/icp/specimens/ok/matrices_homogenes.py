"""Homogeneous matrices, multiplied on the left."""
def T(R, t):
    M = np.eye(3)
    M[:2, :2], M[:2, 2] = R, t
    return M


def icp(P, Q, R0, t0, n_iter=30):
    M = T(R0, t0)
    h = np.vstack([P.T, np.ones(len(P))])
    E = []
    for i in range(n_iter):
        A = (M @ h)[:2].T
        D = ((A[:, None, :] - Q) ** 2).sum(-1)
        B = Q[D.argmin(1)]
        U, s, Vt = np.linalg.svd((A - A.mean(0)).T @ (B - B.mean(0)))
        V = Vt.T
        if np.linalg.det(V @ U.T) < 0:
            V[:, 1] *= -1
        R = V @ U.T
        M = T(R, B.mean(0) - R @ A.mean(0)) @ M
        E.append((((M @ h)[:2].T - B) ** 2).sum())
    return M[:2, :2], M[:2, 2], np.array(E)
