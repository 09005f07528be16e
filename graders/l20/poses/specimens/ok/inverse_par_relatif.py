"""relatif first, written out; the two others from it: composer(a, b) is b seen from the inverse of a."""
import math


def relatif(depuis, vue):
    ecart = [v - d for v, d in zip(vue, depuis)]
    c, s = math.cos(depuis[2]), math.sin(depuis[2])
    angle = ecart[2]
    angle -= 2 * math.pi * math.floor((angle + math.pi) / (2 * math.pi))
    return np.array([c * ecart[0] + s * ecart[1], c * ecart[1] - s * ecart[0], angle])


def inverse(p):
    return relatif(p, (0, 0, 0))


def composer(p, q):
    return relatif(inverse(p), q)
