"""Squared distances by |a|² − 2ab + |b|²; the cloud itself is moved, and the motion found at the end."""
def kabsch(P, Q):
    p, q = np.mean(P, axis=0), np.mean(Q, axis=0)
    U, S, Vt = np.linalg.svd(np.dot((P - p).T, Q - q))
    D = np.eye(2)
    D[1, 1] = round(np.linalg.det(Vt.T @ U.T))
    R = Vt.T @ D @ U.T
    return R, q - R.dot(p)


def icp(P, Q, R0, t0, n_iter=30):
    A = P @ R0.T + t0
    erreurs = []
    for _ in range(n_iter):
        d2 = (A**2).sum(1)[:, None] - 2 * A @ Q.T + (Q**2).sum(1)
        B = Q[d2.argmin(1)]
        R, t = kabsch(A, B)
        A = A @ R.T + t
        erreurs.append(((A - B) ** 2).sum())
    R, t = kabsch(P, A)
    return R, t, erreurs
