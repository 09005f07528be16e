def n_eff(poids):
    return len(poids) * np.sum(poids**2)
