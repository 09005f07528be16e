"""Whole parts first, then a comb over what remains: the same guarantees for each particle."""


def n_eff(poids):
    return 1 / np.einsum("i,i", poids, poids)


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    parts = n * poids
    entieres = np.floor(parts + 1e-12).astype(int)
    manque = n - entieres.sum()
    if manque > 0:
        restes = np.maximum(parts - entieres, 0)
        fins = np.cumsum(restes * (manque / restes.sum()))
        for m in range(manque):
            entieres[min(np.searchsorted(fins, m + (u if m else (u := rng.random()))), n - 1)] += 1
    return np.vstack([particules[i] for i in range(n) for _ in range(entieres[i])])
