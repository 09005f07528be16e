import math


def lancer_rayon(libres, x, y, angle, portee_max):
    tableau = libres.tolist()
    ouvertes = {(j, i) for j, ligne in enumerate(tableau) for i, ok in enumerate(ligne) if ok}
    pas, t = 0.05, 0.0
    while (math.floor(y + math.sin(angle) * t), math.floor(x + math.cos(angle) * t)) in ouvertes:
        t += pas
        if t > portee_max:
            break
    return min(t, portee_max)
