"""P and Q are subtracted row by row: with unequal sizes, numpy refuses."""


def icp(P, Q, R0, t0, n_iter=30):
    R, t = R0, t0
    for _ in range(n_iter):
        H = (P - P.mean(0)).T @ (Q[: len(P) + 1] - Q.mean(0)) @ np.ones((3, 1))
        U, S, Vt = np.linalg.svd(H)
        R = Vt.T @ U.T
    return R, t, [0.0]
