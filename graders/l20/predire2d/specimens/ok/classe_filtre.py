class Filtre:
    """The belief as an object that moves and looks."""

    def __init__(self, croyance):
        self.p = np.array(croyance, dtype=float)

    def deplace(self, dx, dy):
        ailleurs = np.zeros_like(self.p)
        for y, x in zip(*np.nonzero(self.p)):
            a, b = y + dy, x + dx
            ou = (a, b) if 0 <= a < H and 0 <= b < W and libres[a, b] else (y, x)
            ailleurs[ou] += self.p[y, x]
        return Filtre(ailleurs)

    def __rmul__(self, nombre):
        return Filtre(nombre * self.p)

    def __add__(self, autre):
        return Filtre(self.p + autre.p)

    def regarde(self, scan, sigma):
        for y, x in zip(*np.nonzero(self.p)):
            ecarts = scan - lidar(np.array([x + 0.5, y + 0.5, 0.0]), n_rayons=4)
            self.p[y, x] *= np.exp(-ecarts @ ecarts / (2 * sigma**2))
        self.p /= self.p.sum()
        return self


def predire2d(bel, du, dv):
    f = Filtre(bel)
    return (0.8 * f.deplace(du, dv) + 0.1 * f.deplace(du + dv, dv + du) + 0.1 * f.deplace(du - dv, dv - du)).p


def corriger2d(bel, scan_obs, sigma=0.5):
    return Filtre(bel).regarde(scan_obs, sigma).p
