from fractions import Fraction


def gain(v, r):
    v, r = Fraction(v), Fraction(r)
    return float(v / (v + r))


def fusionner(mesures, variances):
    poids = [1 / Fraction(float(r)) for r in variances]
    somme = sum(poids)
    return float(sum(p * Fraction(float(z)) for p, z in zip(poids, mesures)) / somme), float(1 / somme)


def enchainer(m, v, mesures, variances):
    m, v, lignes = Fraction(m), Fraction(v), []
    for z, r in zip(map(float, mesures), map(float, variances)):
        total = v + Fraction(r) or 1
        m, v = m + v * (Fraction(z) - m) / total, v * Fraction(r) / total
        lignes.append((float(m), float(v)))
    return lignes
