import gtsam


def dimension_noyau(poses, aretes):
    return gtsam.noyau(poses, aretes)


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    return gtsam.optimiser(poses, aretes, delta, n_iter)
