"""The comb is read backwards: the last tooth first; the copies stand in the other order."""


def n_eff(poids):
    return np.reciprocal(np.square(poids).sum())


def reechantillonner_systematique(particules, poids):
    n, d = particules.shape
    sortie = np.empty((n, d))
    i, debut = n - 1, 1.0 - poids[n - 1]
    u = rng.random()
    for rang, m in enumerate(reversed(range(n))):
        dent = (m + u) / n
        while dent < debut and i > 0:
            i -= 1
            debut -= poids[i]
        sortie[rang, :] = particules[i, :]
    return sortie
