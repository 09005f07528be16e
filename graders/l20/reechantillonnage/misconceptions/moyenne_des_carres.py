def n_eff(poids):
    return 1.0 / np.mean(poids**2)
