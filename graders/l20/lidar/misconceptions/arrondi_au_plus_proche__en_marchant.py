def lancer_rayon(libres, x, y, angle, portee_max):
    hauteur, largeur = libres.shape
    t = 0.0
    while t < portee_max:
        j, i = round(y + t * math.sin(angle)), round(x + t * math.cos(angle))
        if not (0 <= j < hauteur and 0 <= i < largeur) or not libres[j, i]:
            return t
        t += 0.02
    return portee_max
