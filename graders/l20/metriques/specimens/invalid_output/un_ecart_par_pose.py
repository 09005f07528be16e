def ate(estimees, verite):
    return np.linalg.norm(estimees[:, :2] - verite[:, :2], axis=1)


def rpe(estimees, verite, delta):
    print(delta)
