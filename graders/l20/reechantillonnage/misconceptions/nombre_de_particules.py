def n_eff(poids):
    return float(len(poids))
