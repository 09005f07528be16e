def entree(a, b, p, d):
    """L'intervalle des t où p + t·d est entre a et b."""
    if abs(d) < 1e-12:
        return (-np.inf, np.inf) if a < p < b else (np.inf, -np.inf)
    t1, t2 = (a - p) / d, (b - p) / d
    return min(t1, t2), max(t1, t2)


def lancer_rayon(libres, x, y, angle, portee_max):
    H, W = libres.shape
    dx, dy = np.cos(angle), np.sin(angle)
    sortie = min(entree(0, W, x, dx)[1], entree(0, H, y, dy)[1])
    distances = [portee_max, sortie]
    for ligne, colonne in np.argwhere(~libres):
        ax, bx = entree(colonne, colonne + 1, x, dx)
        ay, by = entree(ligne, ligne + 1, y, dy)
        if max(ax, ay, 0) < min(bx, by):
            distances.append(max(ax, ay))
    return min(distances)
