class Arete:
    def __init__(self, xi, xj, z):
        self.xi, self.xj, self.z = xi, xj, z
        self.c, self.s = np.cos(xi[2]), np.sin(xi[2])

    @property
    def place(self):
        d = self.xj[:2] - self.xi[:2]
        return np.array([self.c * d[0] + self.s * d[1], self.c * d[1] - self.s * d[0]])

    @property
    def e(self):
        angle = self.xj[2] - self.xi[2] - self.z[2]
        while angle > np.pi:
            angle -= 2 * np.pi
        while angle <= -np.pi:
            angle += 2 * np.pi
        return np.append(self.place - self.z[:2], angle)

    @property
    def J(self):
        u, v = self.place
        Rt = np.array([[self.c, self.s], [-self.s, self.c]])
        haut = np.hstack([-Rt, [[v], [-u]], Rt, np.zeros((2, 1))])
        return np.vstack([haut, [0, 0, -1, 0, 0, 1]])


def residu(xi, xj, z):
    return Arete(xi, xj, z).e


def jacobiennes(xi, xj, z):
    J = Arete(xi, xj, z).J
    return J[:, :3], J[:, 3:]


def contribution(xi, xj, z, omega):
    a = Arete(xi, xj, z)
    return a.J.T @ omega @ a.J, a.J.T @ omega @ a.e
