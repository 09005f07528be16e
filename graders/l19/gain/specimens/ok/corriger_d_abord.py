"""One correction, as in the exercise before, and everything made of it; the fusion by halves."""


def corriger(m, v, z, r):
    total = v + r
    return (r * m + v * z) / total, v * r / total


def gain(v, r):
    moyenne, _ = corriger(0.0, v, 1.0, r)
    return moyenne


def fusionner(mesures, variances):
    n = len(mesures)
    if n == 1:
        return mesures[0], variances[0]
    moitie = n // 2
    return corriger(*fusionner(mesures[:moitie], variances[:moitie]), *fusionner(mesures[moitie:], variances[moitie:]))


def enchainer(m, v, mesures, variances):
    croyances = [(m, v)]
    for mesure in zip(mesures, variances):
        croyances.append(corriger(*croyances[-1], *mesure))
    return croyances[1:]
