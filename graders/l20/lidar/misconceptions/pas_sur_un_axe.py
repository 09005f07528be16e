def lancer_rayon(libres, x, y, angle, portee_max):
    hauteur, largeur = libres.shape
    dx, dy = math.cos(angle), math.sin(angle)
    pas = 0.05 / abs(dx) if abs(dx) > 1e-9 else 0.05
    t = 0.0
    while t < portee_max:
        i, j = math.floor(x + t * dx), math.floor(y + t * dy)
        if not (0 <= j < hauteur and 0 <= i < largeur) or not libres[j, i]:
            return t
        t += pas
    return portee_max
