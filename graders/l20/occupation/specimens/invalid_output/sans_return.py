def vers_logodds(p):
    print(np.log(p / (1 - p)))


def vers_proba(l):
    print(1 / (1 + np.exp(-l)))


def integrer_scan(l, pose, scan, portee_max):
    np.clip(l, -5, 5)
