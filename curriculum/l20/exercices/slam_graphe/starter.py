def erreur(xi, xj, z):
    """L'écart (3,) entre la pose de xj vue depuis xi et la
    mesure z.
    """
    # À vous de jouer.
    return np.array([0.0, 0.0, 0.0])


def gauss_newton(poses, aretes, n_iter=10):
    """Les poses (n, 3) qui rendent Σ eᵀΩe minimale ; la première
    ne bouge pas.
    """
    x = np.array(poses, dtype=float)
    for _ in range(n_iter):
        for i, j, z, omega in aretes:
            e = erreur(x[i], x[j], z)
            # Que faut-il faire de e ?
    return x
