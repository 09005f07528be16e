def n_eff(poids):
    return 1.0 / np.max(poids)
