"""The examples of the statement, whatever is asked."""


def ate(estimees, verite):
    return 1.0


def rpe(estimees, verite, delta):
    return np.sqrt(4 / (4 - delta))
