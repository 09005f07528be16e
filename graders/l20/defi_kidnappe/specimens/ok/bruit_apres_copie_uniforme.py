# Roughening : la secousse suit le rééchantillonnage, qui se fait à chaque pas.
def initialiser(n):
    lieux = rng.permutation(np.argwhere(libres))
    lieux = np.resize(lieux, (n, 2))[:, ::-1]
    return np.concatenate([lieux + rng.random((n, 2)), np.linspace(-np.pi, np.pi, n, endpoint=False)[:, None]], axis=1)


def pas_mcl(particules, poids, u, scan):
    x, y, t = particules[:, 0], particules[:, 1], particules[:, 2]
    dx, dy, dt = u
    exact = np.column_stack([x + dx * np.cos(t) - dy * np.sin(t), y + dx * np.sin(t) + dy * np.cos(t), t + dt])
    n = len(exact)
    bouge = exact + rng.standard_normal((n, 3)) * [0.06, 0.06, 0.04]
    s = np.abs(lidar_lot(bouge, 36) - scan)
    l = -np.minimum(s / 0.15, 6).sum(axis=1)
    w = poids * np.exp(l - l.max())
    w /= w.sum()
    restes = n * w
    copies = np.floor(restes).astype(int)
    manque = n - copies.sum()
    if manque:
        frac = restes - copies
        copies += rng.multinomial(manque, frac / frac.sum())
    nuage = np.repeat(bouge, copies, axis=0)
    return nuage + rng.standard_normal((n, 3)) * [0.04, 0.04, 0.02], np.full(n, 1 / n)


def estimer(particules, poids):
    mx = np.sum(particules[:, 0] * poids) / np.sum(poids)
    my = np.sum(particules[:, 1] * poids) / np.sum(poids)
    c = np.sum(np.cos(particules[:, 2]) * poids)
    s = np.sum(np.sin(particules[:, 2]) * poids)
    return np.array([mx, my, np.arctan2(s, c)])

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    # une particule sur vingt, n'importe où ; elles prennent le poids moyen
    k = rng.random(len(p)) < 0.05
    p[k] = np.asarray(initialiser(int(k.sum()))).reshape(-1, 3)
    w[k] = 1 / len(p)
    return p, w / w.sum()
