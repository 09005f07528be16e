"""Closures and lambdas, math for numbers and a loop for arrays, parameters renamed."""
import math


def partout(f):
    def g(v):
        if np.ndim(v) == 0:
            return f(float(v))
        return np.array([g(w) for w in v])
    return g


vers_logodds = partout(lambda p: math.log(p) - math.log(1 - p))
vers_proba = partout(lambda v: 1 / (1 + math.exp(-v)) if v > 0 else math.exp(v) / (1 + math.exp(v)))


def integrer_scan(grille, ou, lus, loin):
    plus = math.log(7 / 3)
    sur = lambda k: lambda d: (
        math.floor(ou[1] + d * math.sin(ou[2] + 2 * math.pi * k / len(lus))),
        math.floor(ou[0] + d * math.cos(ou[2] + 2 * math.pi * k / len(lus))),
    )
    dans = lambda c: 0 <= c[0] < len(grille) and 0 <= c[1] < len(grille[0])
    sortie = [[v for v in ligne] for ligne in grille]
    for k, z in enumerate(lus):
        case = sur(k)
        mur = case(z + 1e-6) if z < loin else None
        passees = {case(d / 50) for d in range(int(50 * min(z, loin)) + 1) if d / 50 < min(z, loin)}
        for c in filter(dans, passees - {mur}):
            sortie[c[0]][c[1]] -= plus
        if mur and dans(mur):
            sortie[mur[0]][mur[1]] += plus
    return np.array([[max(-5, min(5, v)) for v in ligne] for ligne in sortie])
