def ate(estimees, verite):
    """L'écart quadratique moyen des positions, une fois la
    trajectoire estimée posée au mieux sur la vraie.
    """
    # À vous de jouer.
    return 0.0


def rpe(estimees, verite, delta):
    """L'écart quadratique moyen des déplacements, de i à
    i + delta.
    """
    return 0.0
