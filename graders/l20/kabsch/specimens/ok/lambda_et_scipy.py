import scipy.linalg as la

moyenne = lambda X: np.mean(X, 0)
signe = lambda M: np.diag([1.0] * (len(M) - 1) + [round(la.det(M))])
rotation = lambda u, s, vt: (u @ signe(u @ vt) @ vt).T
tourne = lambda P, Q: rotation(*la.svd((P - moyenne(P)).T @ (Q - moyenne(Q)), lapack_driver="gesvd"))
avec_t = lambda R, P, Q: (R, moyenne(Q - P @ R.T))
kabsch = lambda P, Q: avec_t(tourne(P, Q), P, Q)
