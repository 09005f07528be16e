"""Complex numbers throughout: the best rotation is the argument of a sum."""


def ate(estimees, verite):
    p, q = estimees[:, 0] + 1j * estimees[:, 1], verite[:, 0] + 1j * verite[:, 1]
    p, q = p - p.mean(), q - q.mean()
    s = np.vdot(p, q)
    return np.sqrt(np.mean(np.abs(p * s / abs(s) - q) ** 2))


def rpe(estimees, verite, delta):
    def deplacements(x):
        z = x[:, 0] + 1j * x[:, 1]
        return (z[delta:] - z[:-delta]) * np.exp(-1j * x[:-delta, 2])

    return np.sqrt(np.mean(np.abs(deplacements(estimees) - deplacements(verite)) ** 2))
