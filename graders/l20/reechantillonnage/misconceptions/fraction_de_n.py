def n_eff(poids):
    return 1.0 / (len(poids) * np.sum(poids**2))
