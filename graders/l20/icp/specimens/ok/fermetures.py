"""Closures and functools.reduce; the pair comes back as a list."""
from functools import reduce


def icp(P, Q, R0, t0, n_iter=30):
    mouvement = lambda R, t: lambda X: X @ R.T + t
    choisir = lambda A: Q[np.argmin(((A[:, None] - Q[None]) ** 2).sum(2), 1)]

    def fit(X, Y):
        x, y = X.mean(0), Y.mean(0)
        H = (X - x).T @ (Y - y)
        c, s = H[0, 0] + H[1, 1], H[0, 1] - H[1, 0]
        r = np.hypot(c, s)
        R = np.array([[c, -s], [s, c]]) / r
        return R, y - R @ x

    def etape(etat, _):
        R, t, E = etat
        Y = choisir(mouvement(R, t)(P))
        R, t = fit(P, Y)
        return R, t, E + [float(((mouvement(R, t)(P) - Y) ** 2).sum())]

    return list(reduce(etape, range(n_iter), (R0, t0, [])))
