def kabsch(P, Q):
    n, d = P.shape
    p = P.mean(axis=0)
    q = Q.mean(axis=0)
    A = P - p
    B = Q - q
    H = A.T @ B
    U, S, Vt = np.linalg.svd(H)
    V = Vt.T
    sens = np.sign(np.linalg.det(V @ U.T))
    D = np.diag([1.0] * (d - 1) + [sens])
    R = V @ D @ U.T
    t = q - R @ p
    return R, t
