_gauss_newton_juste = gauss_newton


def gauss_newton(poses, aretes, n_iter=10):
    x = np.array(poses, dtype=float)
    x[0] = 0.0
    return _gauss_newton_juste(x, aretes, n_iter)
