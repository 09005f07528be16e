"""Right values, but a view of the arguments is centred in place."""


def ate(estimees, verite):
    P, Q = estimees[:, :2], verite[:, :2]
    P -= P.mean(axis=0)
    Q -= Q.mean(axis=0)
    H = P.T @ Q
    a = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
    R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return np.sqrt(np.mean(np.sum((P @ R.T - Q) ** 2, axis=1)))


def rpe(estimees, verite, delta):
    def mouvements(x):
        z = x[:, 0] + 1j * x[:, 1]
        return (z[delta:] - z[:-delta]) * np.exp(-1j * x[:-delta, 2])

    return np.sqrt(np.mean(np.abs(mouvements(estimees) - mouvements(verite)) ** 2))
