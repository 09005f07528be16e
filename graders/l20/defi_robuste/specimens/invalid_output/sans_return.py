def dimension_noyau(poses, aretes):
    noyau = 3


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    poids = np.ones(len(aretes))
