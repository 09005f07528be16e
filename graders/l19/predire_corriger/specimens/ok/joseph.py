"""The variance by the form of Joseph, right for any gain."""


def predire(m, v, u, q):
    avance, doute = m, v
    avance += u
    doute += q
    return avance, doute


def corriger(m, v, z, r):
    S = v + r
    K = v * S**-1
    innovation = z - m
    return m + K * innovation, (1 - K) ** 2 * v + K**2 * r
