def ate(estimees, verite):
    P = estimees[:, :2
    return 0.0


def rpe(estimees, verite, delta):
    return 0.0
