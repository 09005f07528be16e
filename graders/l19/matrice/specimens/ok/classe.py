class Filtre:
    def __init__(self, x, P):
        self.x, self.P = np.array(x, dtype=float), np.array(P, dtype=float)

    def avance(self, F, Q):
        self.x = F @ self.x
        self.P = F @ self.P @ F.T + Q
        return self

    def regarde(self, z, H, R):
        y = z - H @ self.x
        croisee = self.P @ H.T
        S = H @ croisee + R
        self.x = self.x + croisee @ np.linalg.solve(S, y)
        self.P = self.P - croisee @ np.linalg.solve(S, croisee.T)
        return self

    def __iter__(self):
        yield self.x
        yield self.P


def predire(x, P, F, Q):
    return tuple(Filtre(x, P).avance(F, Q))


def corriger(x, P, z, H, R):
    return tuple(Filtre(x, P).regarde(z, H, R))
