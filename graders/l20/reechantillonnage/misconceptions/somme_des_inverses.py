def n_eff(poids):
    with np.errstate(divide="ignore"):
        return np.sum(1.0 / poids**2)
