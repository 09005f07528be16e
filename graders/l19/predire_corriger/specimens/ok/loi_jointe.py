"""The joint law of the position and of the reading, then the conditional one; prints what it does."""


def predire(m, v, u, q):
    passage = np.array([1.0, 1.0])
    print("on avance de", u)
    return passage @ np.array([m, u]), passage @ np.diag([v, q]) @ passage


def corriger(m, v, z, r):
    jointe = np.array([[v, v], [v, v + r]])
    pente = jointe[0, 1] / jointe[1, 1]
    return m + pente * (z - m), jointe[0, 0] - pente * jointe[1, 0]
