class Balise:
    def __init__(self, position):
        self.position = position

    def lecture(self, x):
        return float(np.hypot(*(x - self.position)))

    def derivee(self, x):
        return (x - self.position) / self.lecture(x)


class Filtre:
    def __init__(self, x, P):
        self.x, self.P = x, P

    def corrige(self, z, capteur, r):
        H, attendu = capteur.derivee(self.x), capteur.lecture(self.x)
        self.S = H @ self.P @ H + r
        self.K = self.P @ H / self.S
        return self.x + self.K * (z - attendu), self.P - self.S * np.outer(self.K, self.K)


def distance_et_jacobien(x, balise):
    capteur = Balise(balise)
    return capteur.lecture(x), capteur.derivee(x)


def corriger_distance(x, P, z, balise, r):
    return Filtre(x, P).corrige(z, Balise(balise), r)
