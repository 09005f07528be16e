def dimension_noyau(poses, aretes):
    return 3 * len(poses) - aretes.shape[0]


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    poids = np.ones(aretes.shape[0])
    return poses, poids
