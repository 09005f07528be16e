"""All is right, but t0 grows in place."""


def icp(P, Q, R0, t0, n_iter=30):
    R, t = R0.copy(), t0
    erreurs = []
    for _ in range(n_iter):
        A = P @ R.T + t
        B = Q[np.argmin(np.sum((A[:, None] - Q) ** 2, axis=2), axis=1)]
        U, _, Vt = np.linalg.svd((A - A.mean(0)).T @ (B - B.mean(0)))
        D = np.diag([1, np.sign(np.linalg.det(Vt.T @ U.T))])
        dR = Vt.T @ D @ U.T
        R = dR @ R
        t[:] = dR @ t + B.mean(0) - dR @ A.mean(0)
        erreurs.append(np.sum((P @ R.T + t - B) ** 2))
    return R, t, erreurs
