"""Everything at once, by einsum."""


def rotations(angles):
    c, s = np.cos(angles), np.sin(angles)
    return np.array([[c, -s], [s, c]]).transpose(2, 0, 1)


def ate(estimees, verite):
    centre = lambda X: X[:, :2] - X[:, :2].mean(0)
    A, B = centre(estimees), centre(verite)
    H = np.einsum("ni,nj->ij", A, B)
    R = rotations(np.array([np.arctan2(H[0, 1] - H[1, 0], np.trace(H))]))[0]
    E = np.einsum("ij,nj->ni", R, A) - B
    return np.sqrt(np.einsum("ni,ni->", E, E) / len(E))


def rpe(estimees, verite, delta):
    locaux = [
        np.einsum("nji,nj->ni", rotations(X[:-delta, 2]), X[delta:, :2] - X[:-delta, :2]) for X in (estimees, verite)
    ]
    E = locaux[0] - locaux[1]
    return np.sqrt(np.einsum("ni,ni->n", E, E).mean())
