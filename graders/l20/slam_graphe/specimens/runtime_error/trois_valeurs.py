def erreur(xi, xj, z):
    return relatif(xi, xj) - z


def gauss_newton(poses, aretes, n_iter=10):
    for i, j, z in aretes:
        erreur(poses[i], poses[j], z)
    return poses
