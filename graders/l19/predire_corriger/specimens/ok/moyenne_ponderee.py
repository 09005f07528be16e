"""The new mean as a weighted mean of both, the new variance as their product over their sum."""


def predire(moyenne, variance, deplacement, bruit):
    return [moyenne + deplacement, variance + bruit]


def corriger(moyenne, variance, mesure, bruit):
    total = variance + bruit
    return [(bruit * moyenne + variance * mesure) / total, variance * bruit / total]
