def lancer_rayon(libres, x, y, angle, portee_max):
    c, s = np.cos(angle), np.sin(angle)
    T = np.array([[c, -s, x], [s, c, y], [0, 0, 1]])
    t = np.append(np.arange(0.0, portee_max, 0.025), portee_max)
    points = T @ np.vstack([t, np.zeros_like(t), np.ones_like(t)])
    colonnes, lignes = np.floor(points[:2]).astype(int)
    dehors = (colonnes < 0) | (colonnes >= libres.shape[1]) | (lignes < 0) | (lignes >= libres.shape[0])
    occupe = dehors | ~libres[np.clip(lignes, 0, libres.shape[0] - 1), np.clip(colonnes, 0, libres.shape[1] - 1)]
    return t[occupe][0] if occupe.any() else portee_max
