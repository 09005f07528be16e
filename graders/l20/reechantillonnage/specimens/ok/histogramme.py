"""np.histogram counts the teeth between two ends."""


def n_eff(poids):
    return np.sum(poids) ** 2 / np.sum(np.power(poids, 2))


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    bords = np.append(0.0, np.cumsum(poids))
    bords[-1] = 1.0
    bords = np.maximum.accumulate(np.minimum(bords, 1.0))
    copies, _ = np.histogram((np.arange(n) + rng.random()) / n, bins=bords)
    return np.concatenate([np.tile(p, (c, 1)) for p, c in zip(particules, copies) if c])
