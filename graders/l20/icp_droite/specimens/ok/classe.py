class Directions:
    def __init__(self, A, seuil):
        self.forces, self.axes = np.linalg.eigh(A)
        self.libre = self.forces < seuil

    @property
    def libres(self):
        return self.axes.T[self.libre]

    def pas(self, g):
        composantes = self.axes.T @ g
        composantes[self.libre] = 0
        composantes[~self.libre] /= self.forces[~self.libre]
        return -self.axes @ composantes


class Mur:
    def __init__(self, Q):
        self.Q = Q

    def corde(self, k):
        return self.Q[min(k + 1, len(self.Q) - 1)] - self.Q[max(k - 1, 0)]

    def normale(self, k):
        t = self.corde(k) / np.linalg.norm(self.corde(k))
        return np.array([t[1], -t[0]])


def normales(Q):
    mur = Mur(Q)
    return np.array([mur.normale(k) for k in range(len(Q))])


def systeme_droite(P, Q, N):
    a = P - P.mean(axis=0, keepdims=True)
    J = np.zeros((len(P), 3))
    J[:, :2] = N
    J[:, 2] = (np.column_stack([-a[:, 1], a[:, 0]]) * N).sum(axis=1)
    r = ((P - Q) * N) @ np.ones(2)
    return np.mean([np.outer(j, j) for j in J], axis=0), np.mean(J * r[:, None], axis=0)


def directions_libres(A, seuil=0.01):
    return Directions(A, seuil).libres


def pas_droite(A, g, seuil=0.01):
    return Directions(A, seuil).pas(g)
