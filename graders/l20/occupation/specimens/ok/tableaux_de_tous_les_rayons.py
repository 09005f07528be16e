"""All rays and all steps in one array; bincount of votes, one a ray."""
@np.vectorize
def vers_logodds(p):
    return -np.log(1 / p - 1)


def vers_proba(l):
    l = np.asarray(l, dtype=float)
    e = np.exp(-np.abs(l))
    return np.where(l >= 0, 1 / (1 + e), e / (1 + e))


def integrer_scan(l, pose, scan, portee_max):
    n, (h, w) = len(scan), l.shape
    a = pose[2] + 2 * np.pi * np.arange(n) / n
    d = np.arange(0, portee_max, 0.02)
    x = pose[0] + np.outer(np.cos(a), d)
    y = pose[1] + np.outer(np.sin(a), d)
    i, j = np.floor(y).astype(int), np.floor(x).astype(int)
    fi = np.floor(pose[1] + (scan + 1e-6) * np.sin(a)).astype(int)
    fj = np.floor(pose[0] + (scan + 1e-6) * np.cos(a)).astype(int)
    touche = scan < portee_max
    bon = (d[None, :] < scan[:, None]) & (i >= 0) & (i < h) & (j >= 0) & (j < w)
    bon &= ~(touche[:, None] & (i == fi[:, None]) & (j == fj[:, None]))
    rayon = np.repeat(np.arange(n), len(d)).reshape(n, -1)
    uniques = np.unique(np.stack([rayon[bon], i[bon], j[bon]]), axis=1)
    passages = np.bincount(uniques[1] * w + uniques[2], minlength=h * w)
    ok = touche & (fi >= 0) & (fi < h) & (fj >= 0) & (fj < w)
    arrets = np.bincount(fi[ok] * w + fj[ok], minlength=h * w)
    return np.clip(l + 0.847 * (arrets - passages).reshape(h, w), -5, 5)
