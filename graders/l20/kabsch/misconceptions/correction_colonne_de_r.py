def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    U, _, Vt = np.linalg.svd((P - p).T @ (Q - q))
    R = Vt.T @ U.T
    if np.linalg.det(R) < 0:
        R[:, -1] *= -1
    return R, q - R @ p
