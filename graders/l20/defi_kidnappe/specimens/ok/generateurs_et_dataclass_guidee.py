from dataclasses import dataclass
from itertools import accumulate
from math import atan2, cos, exp, log, sin, pi


@dataclass
class Particule:
    x: float
    y: float
    t: float
    w: float = 0.0

    def avance(self, dx, dy, dt):
        c, s = cos(self.t), sin(self.t)
        return Particule(self.x + c * dx - s * dy, self.y + s * dx + c * dy, self.t + dt, self.w)


def au_hasard():
    while True:
        x, y = W * rng.random(), H * rng.random()
        if libres[int(y), int(x)]:
            yield x, y, pi * (2 * rng.random() - 1)


def initialiser(n):
    source = au_hasard()
    return np.array([next(source) for _ in range(n)])


def pas_mcl(particules, poids, u, scan):
    tirages = iter(rng.standard_normal((len(poids), 3)) * (0.08, 0.08, 0.05) + u)
    nuage = [Particule(*p, w).avance(*next(tirages)) for p, w in zip(particules, poids)]
    scans = lidar_lot([(p.x, p.y, p.t) for p in nuage], 12)
    ecarts = np.minimum(abs(scans - scan[::3]), 2.0)
    for p, e in zip(nuage, (ecarts**2).sum(axis=1)):
        p.w = (log(p.w) if p.w else -700.0) - e / (2 * 0.35**2)
    haut = max(p.w for p in nuage)
    for p in nuage:
        p.w = exp(p.w - haut)
    total = sum(p.w for p in nuage)
    bords = list(accumulate(p.w / total for p in nuage))
    n = len(nuage)
    if sum((p.w / total) ** 2 for p in nuage) > 2 / n:
        dent = rng.random() / n
        choisies, i = [], 0
        for k in range(n):
            while i < n - 1 and bords[i] < dent + k / n:
                i += 1
            choisies.append(nuage[i])
        return np.array([(p.x, p.y, p.t) for p in choisies]), np.full(n, 1 / n)
    return np.array([(p.x, p.y, p.t) for p in nuage]), np.array([p.w / total for p in nuage])


def estimer(particules, poids):
    def moyenne(f):
        return sum(w * f(p) for p, w in zip(particules, poids))

    return np.array([moyenne(lambda p: p[0]), moyenne(lambda p: p[1]), atan2(moyenne(lambda p: sin(p[2])), moyenne(lambda p: cos(p[2])))])

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    n = len(p)
    candidats = np.asarray(initialiser(600))
    cout = np.minimum(np.abs(lidar_lot(candidats, 12) - scan[::3]), 2.0).sum(axis=1)
    meilleurs = candidats[np.argsort(cout)[: n // 20]]
    places = rng.choice(n, len(meilleurs), replace=False)
    p[places] = meilleurs + rng.normal(0, 0.03, meilleurs.shape)
    w[places] = 1.0 / n
    return p, w / w.sum()


def estimer(particules, poids):
    p, w = np.asarray(particules, dtype=float), np.asarray(poids, dtype=float)
    boites = {}
    for (x, y, t), v in zip(p, w):
        b = (int(x), int(y), int(np.floor(t / (np.pi / 4))) % 8)
        boites[b] = boites.get(b, 0.0) + v
    i, j, _ = max(boites, key=boites.get)
    pres = np.hypot(p[:, 0] - i - 0.5, p[:, 1] - j - 0.5) < 1.2
    c = w[pres] @ np.exp(1j * p[pres, 2])
    return np.array([*(w[pres] @ p[pres, :2] / w[pres].sum()), np.angle(c)])
