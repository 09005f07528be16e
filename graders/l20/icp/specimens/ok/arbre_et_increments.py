"""A k-d tree; increments composed; errors before the move, as in the lesson."""
from scipy.spatial import cKDTree


def icp(P, Q, R0, t0, n_iter=30):
    arbre = cKDTree(Q)
    R, t, erreurs = R0.copy(), t0.copy(), []
    for _ in range(n_iter):
        deplace = P @ R.T + t
        d, paires = arbre.query(deplace)
        erreurs.append(np.sum(d**2))
        a, b = deplace.mean(0), Q[paires].mean(0)
        U, _, Vt = np.linalg.svd((deplace - a).T @ (Q[paires] - b))
        S = np.diag([1, np.linalg.det(Vt.T @ U.T)])
        dR = Vt.T @ S @ U.T
        R, t = dR @ R, dR @ t + b - dR @ a
    return R, t, erreurs
