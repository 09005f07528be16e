"""The logarithm of a curve is a parabola: two parabolas are added, and the summit of the sum is read."""


def parabole(moyenne, variance):
    return np.poly1d([1 / variance, -2 * moyenne / variance, moyenne**2 / variance])


def corriger(m, v, z, r):
    a, b, _ = (parabole(m, v) + parabole(z, r)).coeffs
    return -b / (2 * a), 1 / a


def predire(m, v, u, q):
    return m + u, v + q
