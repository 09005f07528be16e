"""Right copies, written over the given particles, and weights cumulated in place."""


def n_eff(poids):
    poids **= 2
    return 1 / poids.sum()


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    np.cumsum(poids, out=poids)
    indices = np.searchsorted(poids, (np.arange(n) + rng.random()) / n)
    particules[:] = particules[np.minimum(indices, n - 1)]
    return particules
