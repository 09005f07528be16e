import filterpy.kalman


def predire(m, v, u, q):
    return filterpy.kalman.predict((m, v), u, q)


def corriger(m, v, z, r):
    return filterpy.kalman.update((m, v), z, r)
