def lancer_rayon(libres, x, y, angle, portee_max):
    t = 0.0
    while t < portee_max:
        i, j = x + t * np.cos(angle), y + t * np.sin(angle)
        if not (0 <= i < libres.shape[1] and 0 <= j < libres.shape[0] and libres[int(j), int(i)]):
            break
        t += 0.05
    print("distance :", min(t, portee_max))
