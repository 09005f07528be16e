"""Stops when the error falls by less than a millionth."""
def icp(P, Q, R0, t0, n_iter=30):
    R, t = R0, t0
    erreurs = [np.inf]
    for k in range(n_iter):
        carres = ((P @ R.T + t)[:, None] - Q) ** 2
        voisins = carres.sum(axis=2).argmin(axis=1)
        cible = Q[voisins]
        Pc, Cc = P - P.mean(axis=0), cible - cible.mean(axis=0)
        U, S, V = np.linalg.svd(Pc.T @ Cc)
        d = 1 if np.linalg.det(U @ V) > 0 else -1
        R = (U @ np.diag([1, d]) @ V).T
        t = cible.mean(axis=0) - P.mean(axis=0) @ R.T
        erreurs.append(((P @ R.T + t - cible) ** 2).sum())
        if erreurs[-2] - erreurs[-1] < 1e-6 * erreurs[-1]:
            break
    return R, t, erreurs[1:]
