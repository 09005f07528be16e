"""The remaining copies go to distinct particles, within floor and ceil, but not with the right chances."""


def n_eff(poids):
    return 1 / np.sum(poids**2)


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    copies = np.floor(n * poids + 1e-9).astype(int)
    reste = np.maximum(n * poids - copies, 0)
    manque = n - copies.sum()
    if manque:
        choisies = rng.choice(n, manque, replace=False, p=reste / reste.sum())
        copies[choisies] += 1
    return np.repeat(particules, copies, axis=0)
