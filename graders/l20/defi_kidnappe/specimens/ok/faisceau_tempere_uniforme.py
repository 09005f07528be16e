"""Modèle de faisceau à quatre termes, douze rayons, puissance 0,5 ; arrondi des caps dans ]-pi, pi]."""
from __future__ import annotations

A_HIT, A_COURT, A_MAX, A_HASARD = 0.7, 0.1, 0.1, 0.1


def ramener(a):
    return np.pi - (np.pi - a) % (2 * np.pi)


def initialiser(n: int):
    ys, xs = np.nonzero(libres)
    k = rng.integers(0, xs.size, n)
    return np.stack([xs[k] + rng.random(n), ys[k] + rng.random(n), ramener(rng.random(n) * 2 * np.pi)], axis=1)


def log_faisceau(z, attendu, sigma=0.4):
    p = A_HIT * np.exp(-((z - attendu) ** 2) / (2 * sigma**2)) / (sigma * np.sqrt(2 * np.pi))
    p = p + A_COURT * 0.5 * np.exp(-0.5 * z) * (z <= attendu) + A_MAX * (z >= PORTEE_MAX) + A_HASARD / PORTEE_MAX
    return np.log(p)


def pas_mcl(particules, poids, u, scan):
    d = np.hypot(u[0], u[1])
    direction = np.arctan2(u[1], u[0])
    n = len(particules)
    cap = particules[:, 2] + direction + 0.1 * rng.standard_normal(n)
    avance = d + 0.08 * rng.standard_normal(n)
    nuage = np.empty_like(particules)
    nuage[:, 0] = particules[:, 0] + avance * np.cos(cap)
    nuage[:, 1] = particules[:, 1] + avance * np.sin(cap)
    nuage[:, 2] = ramener(particules[:, 2] + u[2] + 0.05 * rng.standard_normal(n))
    l = 0.5 * log_faisceau(scan[::3], lidar_lot(nuage, 12)).sum(axis=1)
    w = poids * np.exp(l - l.max())
    w /= w.sum()
    if 1 / np.sum(w * w) < n / 2:
        dents = (np.arange(n) + rng.uniform()) / n
        nuage = nuage[np.minimum(np.searchsorted(np.cumsum(w), dents), n - 1)]
        w = np.full(n, 1.0 / n)
    return nuage, w


def estimer(particules, poids):
    m = poids @ particules
    m[2] = np.arctan2(poids @ np.sin(particules[:, 2]), poids @ np.cos(particules[:, 2]))
    return m

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    # une particule sur vingt, n'importe où ; elles prennent le poids moyen
    k = rng.random(len(p)) < 0.05
    p[k] = np.asarray(initialiser(int(k.sum()))).reshape(-1, 3)
    w[k] = 1 / len(p)
    return p, w / w.sum()
