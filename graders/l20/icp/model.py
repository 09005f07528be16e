def kabsch(P, Q):
    p = P.mean(axis=0)
    q = Q.mean(axis=0)
    U, S, Vt = np.linalg.svd((P - p).T @ (Q - q))
    D = np.diag([1.0, np.sign(np.linalg.det(Vt.T @ U.T))])
    R = Vt.T @ D @ U.T
    return R, q - R @ p


def plus_proches(A, Q):
    ecarts = A[:, None] - Q[None]
    distances = np.sum(ecarts**2, axis=2)
    return np.argmin(distances, axis=1)


def icp(P, Q, R0, t0, n_iter=30):
    R, t = np.array(R0), np.array(t0)
    erreurs = []
    for _ in range(n_iter):
        A = P @ R.T + t
        paires = plus_proches(A, Q)
        dR, dt = kabsch(A, Q[paires])
        R = dR @ R
        t = dR @ t + dt
        carres = np.sum((P @ R.T + t - Q[paires]) ** 2, axis=1)
        erreurs.append(np.sum(carres))
    return R, t, erreurs
