def predire(m, v, u, q):
    """La croyance après un déplacement u, connu à la variance q près."""
    # La cloche se déplace avec le robot...
    moyenne = m + u
    # ... et s'élargit : l'erreur du déplacement est indépendante, les variances s'ajoutent.
    variance = v + q
    return moyenne, variance


def corriger(m, v, z, r):
    """La croyance après une mesure z, de variance r."""
    # Le gain est la part de confiance qui va à la mesure : plus la croyance est vague, plus il est près de 1.
    gain = v / (v + r)
    # On fait une fraction du chemin qui sépare la prédiction de la mesure.
    moyenne = m + gain * (z - m)
    # Une mesure n'enlève jamais d'information : la variance diminue toujours.
    variance = (1 - gain) * v
    return moyenne, variance
