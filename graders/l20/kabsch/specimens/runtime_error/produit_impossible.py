"""The transposition is forgotten: (n, d) @ (n, d) cannot be computed."""


def kabsch(P, Q):
    H = (P - P.mean(axis=0)) @ (Q - Q.mean(axis=0))
    U, S, Vt = np.linalg.svd(H)
    R = Vt.T @ U.T
    return R, Q.mean(axis=0) - R @ P.mean(axis=0)
