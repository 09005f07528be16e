# L'estimation est la moyenne des particules proches de la plus lourde région.
import math
from scipy.special import logsumexp
from scipy.stats import norm


def initialiser(n):
    yx = np.argwhere(libres)[rng.choice(int(libres.sum()), size=n)]
    return np.concatenate([np.flip(yx, axis=1) + rng.random((n, 2)), rng.uniform(0, math.tau, (n, 1))], axis=1)


def pas_mcl(particules, poids, u, scan):
    n = len(particules)
    d = np.asarray(u) + norm.rvs(scale=[0.09, 0.09, 0.05], size=(n, 3), random_state=rng)
    p = np.array(particules)
    p[:, 0] += np.cos(particules[:, 2]) * d[:, 0] + np.cos(particules[:, 2] + math.pi / 2) * d[:, 1]
    p[:, 1] += np.sin(particules[:, 2]) * d[:, 0] + np.sin(particules[:, 2] + math.pi / 2) * d[:, 1]
    p[:, 2] += d[:, 2]
    z = lidar_lot(p, 36)[:, 1::4]
    l = np.maximum(norm.logpdf(scan[1::4], z, 0.3), -9.0).sum(axis=1) + np.log(poids)
    w = np.exp(l - logsumexp(l))
    w = w / w.sum()
    if 1 / sum(w**2) < n / 2:
        p, w = p[np.searchsorted(np.cumsum(w)[:-1], (rng.random() + np.arange(n)) / n)], np.full(n, 1 / n)
    return p, w


def estimer(particules, poids):
    cases = {}
    for k, (x, y, t) in enumerate(particules):
        cases.setdefault((int(x), int(y)), []).append(k)
    groupe = max(cases.values(), key=lambda ks: sum(poids[k] for k in ks))
    x0, y0 = particules[groupe, :2].mean(axis=0)
    pres = np.hypot(particules[:, 0] - x0, particules[:, 1] - y0) < 1
    w, p = poids[pres] / poids[pres].sum(), particules[pres]
    return (w @ p[:, 0], w @ p[:, 1], math.atan2(w @ np.sin(p[:, 2]), w @ np.cos(p[:, 2])))

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    n = len(w)
    combien = n // 10
    garde = np.argsort(w)[combien:]
    p = np.concatenate([np.asarray(p)[garde], np.asarray(initialiser(combien))])
    w = np.concatenate([np.asarray(w)[garde], np.full(combien, 1.0 / n)])
    return p, w / w.sum()
