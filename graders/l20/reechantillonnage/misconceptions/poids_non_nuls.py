def n_eff(poids):
    return float(np.count_nonzero(poids))
