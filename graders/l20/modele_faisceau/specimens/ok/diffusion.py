def log_vraisemblance(lues, prevues, s, portee, parts, taux):
    d = lues - prevues
    melange = (
        parts[0] * np.exp(-0.5 * d * d / s / s) / np.sqrt(2 * np.pi * s**2)
        + parts[1] * taux * np.exp(-taux * lues) * np.heaviside(-d, 1.0)
        + parts[2] * np.isclose(lues, portee)
        + parts[3] / portee
    )
    return np.log(melange).sum()


def champ_distance(grille):
    h, l = grille.shape
    Y, X = np.mgrid[:h, :l]
    my, mx = np.where(~grille)
    return np.sqrt((Y[..., None] - my) ** 2 + (X[..., None] - mx) ** 2).min(axis=-1)
