"""Right values, but t comes as a column (d, 1)."""


def kabsch(P, Q):
    p, q = P.mean(axis=0)[:, None], Q.mean(axis=0)[:, None]
    U, _, Vt = np.linalg.svd((P.T - p) @ (Q.T - q).T)
    D = np.diag([1.0] * (len(U) - 1) + [np.sign(np.linalg.det(U @ Vt))])
    R = Vt.T @ D @ U.T
    return R, q - R @ p
