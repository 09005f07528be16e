def dimension_noyau(poses, aretes):
    """La dimension du noyau de H, sans qu'aucune pose ne soit
    fixée.
    """
    # À vous de jouer.
    return 0


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    """Les poses (n, 3) corrigées, un poids de [0, 1] par arête,
    petit pour une arête fausse.
    """
    x = np.array(poses, dtype=float)
    poids = np.ones(len(aretes))
    for _ in range(n_iter):
        # Que deviennent les poids, puis les poses ?
        pass
    return x, poids
