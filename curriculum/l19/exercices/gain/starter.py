def gain(v, r):
    """La part de confiance qui va à la mesure."""
    # À vous de jouer.
    return -1.0


def fusionner(mesures, variances):
    """Moyenne et variance de toutes les mesures ensemble."""
    return 0.0, 0.0


def enchainer(m, v, mesures, variances):
    """Une ligne (moyenne, variance) par mesure."""
    return np.zeros((len(mesures), 2))
