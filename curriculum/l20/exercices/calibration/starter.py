def avance(pas):
    """Le long de la corde, positive vers l'avant : n nombres."""
    # À vous de jouer.
    return np.full(len(pas), np.nan)


def etalonner(pas, vrais):
    """Les trois constantes (gamma, beta, alpha)."""
    return np.nan, np.nan, np.nan


def corriger(pas, gamma, beta, alpha):
    """Les pas que le robot a vraiment faits : (n, 3)."""
    return np.full((len(pas), 3), np.nan)
