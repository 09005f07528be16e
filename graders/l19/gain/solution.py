def gain(v, r):
    """La part de confiance qui va à la mesure."""
    # Aucune division par v ou par r seuls : un capteur parfait (r = 0) donne bien 1.
    return v / (v + r)


def fusionner(mesures, variances):
    """La moyenne et la variance de plusieurs mesures indépendantes d'une même grandeur."""
    # Chaque mesure pèse l'inverse de sa variance, sa précision...
    precisions = 1 / variances
    # ... et les précisions s'ajoutent : à plusieurs, on sait toujours mieux.
    moyenne = np.sum(precisions * mesures) / np.sum(precisions)
    variance = 1 / np.sum(precisions)
    return moyenne, variance


def enchainer(m, v, mesures, variances):
    """Les croyances successives, une ligne (moyenne, variance) par mesure."""
    croyances = []
    for i in range(len(mesures)):
        # Le gain change à chaque mesure : plus la croyance est sûre, moins la suivante la déplace.
        K = gain(v, variances[i])
        m = m + K * (mesures[i] - m)
        v = (1 - K) * v
        croyances.append([m, v])
    return np.array(croyances)
