def kabsch(P, Q):
    p, q = P.mean(axis=0), Q.mean(axis=0)
    U, _, Vt = np.linalg.svd((P - p).T @ (Q - q))
    V = Vt.T
    if np.linalg.det(V @ U.T) < 0:
        V[:, 0] *= -1
    R = V @ U.T
    return R, q - R @ p
