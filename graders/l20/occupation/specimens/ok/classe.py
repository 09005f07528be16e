"""A class that walks by the two counters of Amanatides and Woo; a dataclass."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


from dataclasses import dataclass


@dataclass
class Rayon:
    x: float
    y: float
    angle: float
    longueur: float

    def __iter__(self):
        dx, dy = np.cos(self.angle), np.sin(self.angle)
        i, j = int(np.floor(self.y)), int(np.floor(self.x))
        si, sj = np.sign(dy), np.sign(dx)
        ti = ((i + (si > 0)) - self.y) / dy if abs(dy) > 1e-12 else np.inf
        tj = ((j + (sj > 0)) - self.x) / dx if abs(dx) > 1e-12 else np.inf
        yield i, j
        while True:
            if min(ti, tj) >= self.longueur - 1e-9:
                return
            if ti < tj:
                i += int(si)
                ti += 1 / abs(dy)
            else:
                j += int(sj)
                tj += 1 / abs(dx)
            yield i, j


class Grille:
    def __init__(self, l):
        self.l = np.array(l)

    def voter(self, case, avis):
        if all(0 <= c < n for c, n in zip(case, self.l.shape)):
            self.l[case] = min(5, max(-5, self.l[case] + avis))


def integrer_scan(l, pose, scan, portee_max):
    g = Grille(l)
    for k, z in enumerate(scan):
        a = pose[2] + 2 * np.pi * k / len(scan)
        fin = z + 1e-6
        mur = (int(np.floor(pose[1] + fin * np.sin(a))), int(np.floor(pose[0] + fin * np.cos(a))))
        for case in Rayon(pose[0], pose[1], a, min(z, portee_max)):
            if z >= portee_max or case != mur:
                g.voter(case, -0.847)
        if z < portee_max:
            g.voter(mur, +0.847)
    return g.l
