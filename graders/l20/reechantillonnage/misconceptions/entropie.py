def n_eff(poids):
    p = poids[poids > 0]
    return np.exp(-np.sum(p * np.log(p)))
