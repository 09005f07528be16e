"""The best angle by a minimisation, whose cost is flat at its bottom: right to the last digits."""
from scipy.optimize import minimize_scalar


def tourne(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def ate(estimees, verite):
    A = estimees[:, :2] - np.mean(estimees[:, :2], axis=0)
    B = verite[:, :2] - np.mean(verite[:, :2], axis=0)

    def cout(angle):
        return np.mean(np.sum((tourne(A, angle) - B) ** 2, axis=1))

    depart = min(np.linspace(-np.pi, np.pi, 73), key=cout)
    trouve = minimize_scalar(cout, bracket=(depart - 0.1, depart, depart + 0.1), tol=1e-12)
    return float(np.sqrt(trouve.fun))


def rpe(estimees, verite, delta):
    somme = 0.0
    n = estimees.shape[0]
    for i, j in zip(range(n), range(delta, n)):
        d = tourne(estimees[j, :2] - estimees[i, :2], -estimees[i, 2])
        v = tourne(verite[j, :2] - verite[i, :2], -verite[i, 2])
        somme += np.sum((d - v) ** 2)
    return np.array((somme / (n - delta)) ** 0.5)
