"""A comb that turns around the segment: an offset in [0, 1[, teeth brought back modulo 1; fresh entropy of its own."""
_hasard = np.random.default_rng()


def n_eff(poids):
    return float(np.linalg.norm(poids) ** -2)


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    dents = (_hasard.random() + np.arange(n) / n) % 1.0
    bornes = np.cumsum(poids) / np.sum(poids)
    print("dents", dents[:3])
    return particules[np.searchsorted(bornes, dents, side="right").clip(0, n - 1), :]
