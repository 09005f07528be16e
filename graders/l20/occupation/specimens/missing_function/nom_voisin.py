def logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer(l, pose, scan, portee_max):
    return l.copy()
