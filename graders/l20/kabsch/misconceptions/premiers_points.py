def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    H = sum(np.outer(P[i] - p, Q[i] - q) for i in range(P.shape[1]))
    U, _, Vt = np.linalg.svd(H)
    D = np.diag([1.0] * (len(U) - 1) + [np.sign(np.linalg.det(Vt.T @ U.T))])
    R = Vt.T @ D @ U.T
    return R, q - R @ p
