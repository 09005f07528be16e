def n_eff(poids):
    # La petite marge évite de tronquer 4 en 3 quand le calcul donne 3,9999999.
    return int(1.0 / np.sum(poids**2) + 1e-9)
