def n_eff(poids):
    return np.sum(poids**2)
