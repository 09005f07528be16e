from math import atan2, cos, sin


class Arete:
    def __init__(self, i, j, z, omega):
        self.i, self.j, self.z, self.omega = i, j, z, omega

    def erreur(self, a, b):
        dx, dy = b[0] - a[0], b[1] - a[1]
        t = b[2] - a[2] - self.z[2]
        return np.array([cos(a[2]) * dx + sin(a[2]) * dy - self.z[0],
                         cos(a[2]) * dy - sin(a[2]) * dx - self.z[1], atan2(sin(t), cos(t))])

    def derivees(self, a, b):
        R = np.array([[cos(a[2]), sin(a[2]), 0], [-sin(a[2]), cos(a[2]), 0], [0, 0, 1]])
        d = R @ (b - a)
        A = -R
        A[0, 2], A[1, 2] = d[1], -d[0]
        return A, R


class Graphe:
    def __init__(self, poses, aretes):
        self.x = [np.array(p, dtype=float) for p in poses]
        self.aretes = [Arete(*a) for a in aretes]

    def tour(self):
        n = len(self.x)
        H = [[np.zeros((3, 3)) for _ in range(n)] for _ in range(n)]
        b = [np.zeros(3) for _ in range(n)]
        for a in self.aretes:
            e = a.erreur(self.x[a.i], self.x[a.j])
            cotes = list(zip((a.i, a.j), a.derivees(self.x[a.i], self.x[a.j])))
            for k, U in cotes:
                b[k] += U.T @ a.omega @ e
                for l, V in cotes:
                    H[k][l] += U.T @ a.omega @ V
        H[0][0] = H[0][0] + np.diag([1e12] * 3)
        for p, d in zip(self.x, np.split(np.linalg.solve(np.block(H), -np.hstack(b)), n)):
            p += d
            p[2] = atan2(sin(p[2]), cos(p[2]))


def erreur(xi, xj, z):
    return Arete(0, 1, z, None).erreur(xi, xj)


def gauss_newton(poses, aretes, n_iter=10):
    graphe = Graphe(poses, aretes)
    for _ in range(n_iter):
        graphe.tour()
    graphe.x[0] = poses[0]
    return graphe.x
