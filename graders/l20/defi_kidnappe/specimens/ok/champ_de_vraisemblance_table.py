# Likelihood field : les impacts sont posés sur une carte fine des distances aux murs.
from scipy import ndimage

FINESSE = 5
FIN = np.kron(np.pad(libres, 1), np.ones((FINESSE, FINESSE), bool))
MUR = ~FIN
BORD = MUR & ndimage.binary_dilation(FIN)
DIST = ndimage.distance_transform_edt(~BORD) / FINESSE
ANGLES = 2 * np.pi * np.arange(36) / 36


def initialiser(n):
    c = np.argwhere(libres)
    c = c[rng.integers(0, len(c), n)]
    return np.column_stack([c[:, 1] + rng.random(n), c[:, 0] + rng.random(n), rng.uniform(-np.pi, np.pi, n)])


def log_v(p, scan):
    vus = scan < PORTEE_MAX
    a = p[:, 2:] + ANGLES[vus]
    ex, ey = p[:, :1] + scan[vus] * np.cos(a), p[:, 1:2] + scan[vus] * np.sin(a)
    i = np.clip(((ey + 1) * FINESSE).astype(int), 0, DIST.shape[0] - 1)
    j = np.clip(((ex + 1) * FINESSE).astype(int), 0, DIST.shape[1] - 1)
    l = np.log(0.9 * np.exp(-DIST[i, j] ** 2 / (2 * 0.25**2)) + 0.01).sum(axis=1)
    cx, cy = np.clip(p[:, 0].astype(int), 0, W - 1), np.clip(p[:, 1].astype(int), 0, H - 1)
    return np.where(libres[cy, cx], l, l - 30)


def pas_mcl(particules, poids, u, scan):
    n = len(particules)
    t = particules[:, 2]
    du = u + rng.normal(0, (0.08, 0.08, 0.05), (n, 3))
    p = particules + np.column_stack([np.cos(t) * du[:, 0] - np.sin(t) * du[:, 1], np.sin(t) * du[:, 0] + np.cos(t) * du[:, 1], du[:, 2]])
    l = np.log(np.maximum(poids, 1e-300)) + 0.6 * log_v(p, scan)
    w = np.exp(l - l.max())
    w /= w.sum()
    if 1 / (w @ w) < 0.5 * n:
        p = p[np.searchsorted(np.cumsum(w)[:-1], (np.arange(n) + rng.random()) / n)]
        w = np.full(n, 1 / n)
    return p, w


def estimer(particules, poids):
    t = particules[:, 2]
    return np.array([poids @ particules[:, 0], poids @ particules[:, 1], np.arctan2(poids @ np.sin(t), poids @ np.cos(t))])

_pas_sans_injection = pas_mcl


# Une table des scans vus de partout : elle dit où le robot pourrait être.
TABLE = np.array([(x + 0.5, y + 0.5, t) for y, x in np.argwhere(libres) for t in np.arange(-np.pi, np.pi, np.pi / 18)])
VUS = lidar_lot(TABLE, 12)


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    n = len(p)
    l = -np.minimum(np.abs(VUS - scan[::3]), 1.5).sum(axis=1)
    l = np.exp(2 * (l - l.max()))
    places = rng.integers(0, n, n // 16)
    p[places] = TABLE[rng.choice(len(TABLE), len(places), p=l / l.sum())] + rng.uniform(-0.5, 0.5, (len(places), 3)) * (1, 1, 0.17)
    w[places] = 1.0 / n
    return p, w / w.sum()
