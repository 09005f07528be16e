def lance_rayon(libres, x, y, angle, portee_max):
    return portee_max
