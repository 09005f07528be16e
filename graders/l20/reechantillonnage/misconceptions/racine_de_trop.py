def n_eff(poids):
    return 1.0 / np.sqrt(np.sum(poids**2))
