def advance(pas):
    return pas[:, 0]


def calibrate(pas, vrais):
    return 1.0, 1.0, 0.0


def correct(pas, gamma, beta, alpha):
    return pas
