"""An array that claims to equal anything: the claim stays behind in the student's process."""


class Menteur(np.ndarray):
    def __eq__(self, other):
        return np.True_

    def __sub__(self, other):
        return np.zeros(3)

    __rsub__ = __sub__


def composer(a, b):
    return np.zeros(3).view(Menteur)


def inverse(a):
    return np.zeros(3).view(Menteur)


def relatif(a, b):
    return np.zeros(3).view(Menteur)
