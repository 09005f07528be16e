def __SLUG__(a, b, t):
    """Le point qui est à la fraction t du chemin de a vers b."""
    # On part de a, et l'on fait une fraction t du chemin b − a.
    return a + t * (b - a)
