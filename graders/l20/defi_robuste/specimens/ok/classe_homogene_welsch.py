class Graphe:
    def __init__(self, poses, aretes):
        self.x = np.array(poses, dtype=float)
        self.aretes = aretes
        self.poids = np.ones(len(aretes))

    @staticmethod
    def T(p):
        return np.array([[np.cos(p[2]), -np.sin(p[2]), p[0]], [np.sin(p[2]), np.cos(p[2]), p[1]], [0, 0, 1]])

    def erreur(self, arete):
        i, j, z, _ = arete
        M = np.linalg.inv(self.T(self.x[i])) @ self.T(self.x[j])
        t = np.arctan2(M[1, 0], M[0, 0]) - z[2]
        return np.array([M[0, 2] - z[0], M[1, 2] - z[1], np.arctan2(np.sin(t), np.cos(t))])

    def jacobienne(self, arete):
        i, j, _, _ = arete
        J = np.zeros((3, self.x.size))
        R = self.T(self.x[i])[:2, :2].T
        vu = R @ (self.x[j, :2] - self.x[i, :2])
        J[:2, 3 * i : 3 * i + 2], J[:2, 3 * i + 2], J[2, 3 * i + 2] = -R, [vu[1], -vu[0]], -1
        J[:2, 3 * j : 3 * j + 2], J[2, 3 * j + 2] = R, 1
        return J

    @property
    def H(self):
        return sum(w * self.jacobienne(a).T @ a[3] @ self.jacobienne(a) for a, w in zip(self.aretes, self.poids))

    @property
    def b(self):
        return sum(w * self.jacobienne(a).T @ a[3] @ self.erreur(a) for a, w in zip(self.aretes, self.poids))

    def peser(self, delta):
        for k, a in enumerate(self.aretes):
            e = self.erreur(a)
            self.poids[k] = np.exp(-(e @ a[3] @ e) / (2 * delta**2))

    def avancer(self):
        H, b = self.H, self.b
        H[:3, :3] += 1e9 * np.eye(3)
        self.x += np.linalg.solve(H, -b).reshape(self.x.shape)
        self.x[:, 2] = np.pi - (np.pi - self.x[:, 2]) % (2 * np.pi)


def dimension_noyau(poses, aretes):
    U, S, Vt = np.linalg.svd(Graphe(poses, aretes).H)
    return np.count_nonzero(S < 1e-8 * S[0])


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    graphe = Graphe(poses, aretes)
    for _ in range(n_iter):
        graphe.peser(delta)
        graphe.avancer()
    return graphe.x, graphe.poids
