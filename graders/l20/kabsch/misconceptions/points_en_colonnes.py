def kabsch(P, Q):
    p, q = P.mean(axis=1), Q.mean(axis=1)
    U, _, Vt = np.linalg.svd((P - p[:, None]) @ (Q - q[:, None]).T)
    D = np.diag([1.0] * (len(U) - 1) + [np.sign(np.linalg.det(Vt.T @ U.T))])
    R = Vt.T @ D @ U.T
    return R, q - R @ p
