"""A least squares problem in (angle, tx, ty), from three starts; lists of namedtuples."""
from collections import namedtuple

from scipy.optimize import least_squares

Paire = namedtuple("Paire", "debut fin")


def residus(x, P, Q):
    c, s = np.cos(x[0]), np.sin(x[0])
    return (P @ np.array([[c, s], [-s, c]]) + x[1:] - Q).ravel()


def ate(estimees, verite):
    P, Q = estimees[:, :2], verite[:, :2]
    departs = [least_squares(residus, (a, 0, 0), args=(P, Q), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15) for a in (0, 2, 4)]
    return np.sqrt(2 * min(d.cost for d in departs) / len(P))


def rpe(estimees, verite, delta):
    def deplacement(p):
        c, s = np.cos(p.debut[2]), np.sin(p.debut[2])
        return np.linalg.solve([[c, -s], [s, c]], p.fin[:2] - p.debut[:2])

    e = [Paire(*ab) for ab in zip(estimees[:-delta], estimees[delta:])]
    v = [Paire(*ab) for ab in zip(verite[:-delta], verite[delta:])]
    return np.sqrt(np.mean([np.sum((deplacement(a) - deplacement(b)) ** 2) for a, b in zip(e, v)]))
