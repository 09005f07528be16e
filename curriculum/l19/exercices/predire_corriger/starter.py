def predire(m, v, u, q):
    """La croyance après un déplacement u, dont l'erreur a la variance q."""
    # À vous de jouer.
    return 0.0, 0.0


def corriger(m, v, z, r):
    """La croyance après une mesure z, dont l'erreur a la variance r."""
    return 0.0, 0.0
