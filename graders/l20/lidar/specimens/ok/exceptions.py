def lancer_rayon(libres, x, y, angle, portee_max):
    """Un essai, puis on voit : l'indice négatif est refusé à la main."""
    t = 0.0
    try:
        while t < portee_max:
            i, j = int((x + t * np.cos(angle)) // 1), int((y + t * np.sin(angle)) // 1)
            if i < 0 or j < 0:
                raise IndexError
            if not libres[j, i]:
                return t
            t += 0.05
    except IndexError:
        return t
    return portee_max
