def erreur(xi, xj, z):
    e = xj - xi - z


def gauss_newton(poses, aretes, n_iter=10):
    print(len(poses), "poses")
