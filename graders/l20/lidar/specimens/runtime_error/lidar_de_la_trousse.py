def lancer_rayon(libres, x, y, angle, portee_max):
    return lidar((x, y, angle), 1)[0]
