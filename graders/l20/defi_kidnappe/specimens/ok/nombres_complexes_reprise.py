"""Position et cap sont deux nombres complexes."""
import cmath


def en_complexes(p):
    p = np.asarray(p)
    return p[:, 0] + 1j * p[:, 1], np.exp(1j * p[:, 2])


def initialiser(n):
    y, x = np.divmod(rng.choice(np.nonzero(libres.ravel())[0], n), W)
    z = x + rng.random(n) + 1j * (y + rng.random(n))
    return np.column_stack([z.real, z.imag, np.angle(np.exp(2j * np.pi * rng.random(n)))])


def pas_mcl(particules, poids, u, scan):
    z, cap = en_complexes(particules)
    n = len(z)
    dz = complex(u[0], u[1]) + 0.08 * (rng.standard_normal(n) + 1j * rng.standard_normal(n))
    z = z + cap * dz
    cap = cap * cmath.exp(1j * u[2]) * np.exp(0.05j * rng.standard_normal(n))
    p = np.column_stack([z.real, z.imag, np.angle(cap)])
    gauss = np.exp(-0.5 * ((lidar_lot(p, 36) - scan) / 0.5) ** 2)
    L = np.exp(0.4 * np.log(gauss + 0.01).sum(axis=1))
    w = poids * L / np.sum(poids * L)
    if 1 / np.vdot(w, w) < n / 2:
        garde = np.searchsorted(np.cumsum(w), (np.arange(n) + rng.random()) / n).clip(0, n - 1)
        p, w = p[garde], np.full_like(w, 1 / n)
    return p, w


def estimer(particules, poids):
    z, cap = en_complexes(particules)
    centre, direction = np.dot(poids, z), np.dot(poids, cap)
    return np.array([centre.real, centre.imag, cmath.phase(direction)])

_pas_sans_injection = pas_mcl


surprises = 0


def pas_mcl(particules, poids, u, scan):
    global surprises
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    ecart = np.median(np.abs(lidar_lot(p, 12) - scan[::3]), axis=1)
    surprises = surprises + 1 if np.min(ecart) > 0.25 or np.average(ecart, weights=w) > 0.5 else 0
    if surprises >= 3:  # le scan ne ressemble plus à rien : on recommence tout
        surprises = 0
        n = len(p)
        candidats = np.asarray(initialiser(12 * n))
        cout = np.minimum((lidar_lot(candidats, 12) - scan[::3]) ** 2, 4).sum(axis=1)
        l = np.exp(-(cout - cout.min()))
        return candidats[rng.choice(len(candidats), n, p=l / l.sum())], np.ones(n) / n
    return p, w
