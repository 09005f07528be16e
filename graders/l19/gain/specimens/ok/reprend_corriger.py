"""Builds on what the exercise before has written."""
from mes_fonctions import corriger


def gain(v, r):
    moyenne, _ = corriger(0.0, v, 1.0, r)
    return moyenne


def fusionner(mesures, variances):
    croyance = mesures[0], variances[0]
    for mesure in zip(mesures[1:], variances[1:]):
        croyance = corriger(*croyance, *mesure)
    return croyance


def enchainer(m, v, mesures, variances):
    croyances = []
    for mesure in zip(mesures, variances):
        m, v = corriger(m, v, *mesure)
        croyances.append((m, v))
    return croyances
