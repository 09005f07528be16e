"""Without ever moving a point: the squared sizes, less twice the best trace."""


def ate(estimees, verite):
    A = estimees[:, :2] - estimees[:, :2].mean(axis=0)
    B = verite[:, :2] - verite[:, :2].mean(axis=0)
    H = A.T @ B
    valeurs = np.linalg.svd(H, compute_uv=False)
    trace = valeurs[0] + np.sign(np.linalg.det(H)) * valeurs[1]
    return np.sqrt(max(0.0, (np.sum(A**2) + np.sum(B**2) - 2 * trace) / len(A)))


def rpe(estimees, verite, delta):
    erreur = 0
    paires = [(i, i + delta) for i in range(len(estimees)) if i + delta < len(estimees)]
    for i, j in paires:
        pe, pv = estimees[j] - estimees[i], verite[j] - verite[i]
        ecart = verite[i, 2] - estimees[i, 2]
        x = pe[0] * np.cos(ecart) - pe[1] * np.sin(ecart) - pv[0]
        y = pe[0] * np.sin(ecart) + pe[1] * np.cos(ecart) - pv[1]
        erreur += x * x + y * y
    return np.sqrt(erreur / len(paires))
