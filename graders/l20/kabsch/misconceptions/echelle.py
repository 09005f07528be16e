def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    U, S, Vt = np.linalg.svd((P - p).T @ (Q - q))
    D = np.diag([1.0] * (len(U) - 1) + [np.sign(np.linalg.det(Vt.T @ U.T))])
    echelle = np.sum(S * np.diag(D)) / (np.sum((P - p) ** 2) or 1.0)
    R = echelle * Vt.T @ D @ U.T
    return R, q - R @ p
