"""Points as columns, cdist, while loop, default start of the errors by hand."""
from scipy.spatial.distance import cdist


def icp(P, Q, R0, t0, n_iter=30):
    X, Y = P.T, Q.T
    R, t = np.matrix(R0), np.matrix(t0).T
    erreurs = []
    k = 0
    while k < n_iter:
        Z = R * X + t
        C = Y[:, cdist(Z.T, Y.T, "sqeuclidean").argmin(axis=1)]
        cx, cc = X.mean(axis=1, keepdims=True), C.mean(axis=1, keepdims=True)
        U, s, Vt = np.linalg.svd((C - cc) @ (X - cx).T)
        J = np.diag([1, np.linalg.det(U) * np.linalg.det(Vt)])
        R = np.matrix(U @ J @ Vt)
        t = cc - R * cx
        erreurs += [float(np.sum(np.square(R * X + t - C)))]
        k += 1
    return np.asarray(R), np.asarray(t).ravel(), erreurs
