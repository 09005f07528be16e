"""The pairs run past the end of the trajectory."""


def ate(estimees, verite):
    return np.sqrt(np.mean((estimees - verites) ** 2))


def rpe(estimees, verite, delta):
    return sum(np.hypot(*(estimees[i + delta] - verite[i + delta])[:2]) for i in range(len(verite)))
