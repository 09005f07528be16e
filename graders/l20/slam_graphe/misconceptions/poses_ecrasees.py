_gauss_newton_juste = gauss_newton


def gauss_newton(poses, aretes, n_iter=10):
    poses[:] = _gauss_newton_juste(poses, aretes, n_iter)
    return poses
