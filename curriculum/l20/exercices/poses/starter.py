def composer(a, b):
    """La pose b, donnée dans le repère de a, exprimée dans le
    repère du monde.
    """
    x1, y1, t1 = a
    x2, y2, t2 = b
    # À vous de jouer.
    return np.array([0.0, 0.0, 0.0])


def inverse(a):
    """La pose qui, composée avec a, donne (0, 0, 0)."""
    return np.array([0.0, 0.0, 0.0])


def relatif(a, b):
    """La pose b vue depuis a."""
    return np.array([0.0, 0.0, 0.0])
