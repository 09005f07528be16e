def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    U, _, Vt = np.linalg.svd((P - p).T @ (Q - q))
    D = np.diag([1.0] * (len(U) - 1) + [np.sign(np.linalg.det(Vt.T @ U.T))])
    R = Vt.T @ D @ U.T
    return R, Q[0] - R @ P[0]
