def n_eff(poids):
    return 1.0 / np.sum(poids)
