def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    U, _, V = np.linalg.svd((P - p).T @ (Q - q))
    D = np.diag([1.0] * (len(U) - 1) + [np.sign(np.linalg.det(V @ U.T))])
    R = V @ D @ U.T
    return R, q - R @ p
