def __SLUG__(a, b, t):
    """Le point qui est à la fraction t du chemin de a vers b."""
    # À vous de jouer.
    return 0.0
