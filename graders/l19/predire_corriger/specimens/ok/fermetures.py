def affine(pente, ordonnee):
    def applique(x):
        return pente * x + ordonnee

    return applique


def predire(m, v, u, q):
    return affine(1, u)(m), affine(1, q)(v)


def corriger(m, v, z, r):
    garde = r / (r + v)
    return affine(garde, (1 - garde) * z)(m), affine(garde, 0)(v)
