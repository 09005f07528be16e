def erreur(xi, xj, z):
    return xj - xi - z


def gaussnewton(poses, aretes, n_iter=10):
    return poses
