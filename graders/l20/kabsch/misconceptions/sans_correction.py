def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    U, _, Vt = np.linalg.svd((P - p).T @ (Q - q))
    R = Vt.T @ U.T
    return R, q - R @ p
