"""A composition of any number of poses by reduce; a wrap that calls itself."""
from functools import reduce


def ramene(t):
    return t if -np.pi < t <= np.pi else ramene(t - np.sign(t) * 2 * np.pi) if t != -np.pi else np.pi


def deux(a, b):
    direction = np.array([np.cos(a[2]), np.sin(a[2])])
    normale = np.array([-direction[1], direction[0]])
    ou = np.asarray(a[:2]) + b[0] * direction + b[1] * normale
    return (float(ou[0]), float(ou[1]), float(ramene(a[2] + b[2])))


def chaine(*poses):
    return reduce(deux, poses)


def composer(a, b):
    return chaine((0.0, 0.0, 0.0), a, b)


def inverse(a):
    # d'abord revenir au cap 0, puis reculer
    return chaine((0.0, 0.0, -a[2]), (-a[0], -a[1], 0.0))


def relatif(a, b):
    return chaine(inverse(a), b, (0.0, 0.0, 0.0))
