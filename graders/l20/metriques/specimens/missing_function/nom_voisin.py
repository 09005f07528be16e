def ATE(estimees, verite):
    return 0.0


def rpe(estimees, verite, delta):
    return 0.0
