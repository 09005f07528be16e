"""Numbers one by one, lists returned, other parameter names."""
from math import hypot


def distance_et_jacobien(ici, la):
    dx, dy = float(ici[0] - la[0]), float(ici[1] - la[1])
    d = hypot(dx, dy)
    return [d, [dx / d, dy / d]]


def corriger_distance(ici, doute, lu, la, bruit):
    d, (a, b) = distance_et_jacobien(ici, la)
    vers = [doute[0][0] * a + doute[0][1] * b, doute[1][0] * a + doute[1][1] * b]
    s = a * vers[0] + b * vers[1] + bruit
    etat = [ici[i] + vers[i] / s * (lu - d) for i in range(2)]
    return [etat, [[doute[i][j] - vers[i] * vers[j] / s for j in range(2)] for i in range(2)]]
