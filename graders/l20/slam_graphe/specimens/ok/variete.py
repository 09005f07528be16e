"""Steps composed on the right, with the Jacobians that go with them; a little damping; matrices of SE(2)."""
from dataclasses import dataclass


@dataclass
class Pose:
    x: float
    y: float
    t: float

    def matrice(self):
        c, s = np.cos(self.t), np.sin(self.t)
        return np.array([[c, -s, self.x], [s, c, self.y], [0, 0, 1]])


def vecteur(M):
    return np.array([M[0, 2], M[1, 2], np.arctan2(M[1, 0], M[0, 0])])


def plus(a, d):
    return vecteur(Pose(*a).matrice() @ Pose(*d).matrice())


def erreur(a, b, m):
    return vecteur(np.linalg.inv(Pose(*m).matrice()) @ np.linalg.inv(Pose(*a).matrice()) @ Pose(*b).matrice())


def derivee(f, h=1e-5):
    return np.stack([(f(h * v) - f(-h * v)) / (2 * h) for v in np.eye(3)], axis=1)


def gauss_newton(poses, aretes, n_iter=10):
    x = [np.array(p) for p in poses]
    n = len(x)
    for _ in range(n_iter):
        J, W, r = [], [], []
        for i, j, z, omega in aretes:
            ligne = np.zeros((3, 3 * n))
            ligne[:, 3 * i : 3 * i + 3] = derivee(lambda d: erreur(plus(x[i], d), x[j], z))
            ligne[:, 3 * j : 3 * j + 3] = derivee(lambda d: erreur(x[i], plus(x[j], d), z))
            J.append(ligne)
            W.append(omega @ ligne)
            r.append(erreur(x[i], x[j], z))
        H = np.vstack(J).T @ np.vstack(W) + 1e-6 * np.eye(3 * n)
        g = np.vstack(W).T @ np.concatenate(r)
        d = np.linalg.solve(H[3:, 3:], -g[3:])
        x = [x[0]] + [plus(p, d[3 * k : 3 * k + 3]) for k, p in enumerate(x[1:])]
    return x
