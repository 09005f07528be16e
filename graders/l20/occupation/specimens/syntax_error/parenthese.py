def vers_logodds(p):
    return np.log(p / (1 - p)
