"""Every tooth against every end at once, without any search."""


def n_eff(poids):
    return 1 / (np.linalg.norm(poids) ** 2)


def reechantillonner_systematique(particules, poids):
    n = particules.shape[0]
    dents = (rng.random() + np.arange(n)) / n
    fins = np.cumsum(poids)
    fins = fins / fins[-1]
    numeros = (dents[:, None] > fins[None, :]).sum(axis=1)
    return np.take(particules, numeros, axis=0)
