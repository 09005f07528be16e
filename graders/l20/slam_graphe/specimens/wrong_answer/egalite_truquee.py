"""An array that claims to equal anything: the claim stays behind in the student's process."""


class Menteur(np.ndarray):
    def __eq__(self, other):
        return np.True_

    def __sub__(self, other):
        return np.zeros(3)

    __rsub__ = __sub__
    __array_priority__ = 1000


def erreur(xi, xj, z):
    return np.zeros(3).view(Menteur)


def gauss_newton(poses, aretes, n_iter=10):
    return poses.copy().view(Menteur)
