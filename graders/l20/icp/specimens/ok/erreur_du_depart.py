"""The error of the start comes first, n_iter + 1 in all; stops when the pairs repeat themselves."""
from scipy.spatial import cKDTree


def icp(P, Q, R0, t0, n_iter=30):
    arbre = cKDTree(Q)
    R, t = np.array(R0, dtype=float), np.array(t0, dtype=float)
    distances, choix = arbre.query(P @ R.T + t)
    erreurs = [float((distances**2).sum())]
    for _ in range(n_iter):
        q = Q[choix]
        U, _, Vt = np.linalg.svd((P - P.mean(0)).T @ (q - q.mean(0)))
        D = np.diag([1.0, np.sign(np.linalg.det(Vt.T @ U.T))])
        R = Vt.T @ D @ U.T
        t = q.mean(0) - R @ P.mean(0)
        distances, nouveau = arbre.query(P @ R.T + t)
        erreurs.append(float((distances**2).sum()))
        if (nouveau == choix).all():
            break
        choix = nouveau
    return R, t, erreurs
