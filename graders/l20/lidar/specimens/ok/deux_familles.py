
def traversees(p, d, n):
    """Les distances des lignes de la grille devant soi, le long d'un axe."""
    if d > 0:
        return [(k - p) / d for k in range(int(p) + 1, n + 1)]
    return [(k - p) / d for k in range(int(p), -1, -1)] if d < 0 else []


def lancer_rayon(libres, x, y, angle, portee_max):
    H, W = libres.shape
    u, v = np.cos(angle), np.sin(angle)
    reponse = portee_max
    for t in traversees(x, u, W):
        colonne = round(x + t * u) - (u < 0)
        ligne = int(np.floor(y + t * v))
        if not (0 <= ligne < H) or not (0 <= colonne < W) or not libres[ligne, colonne]:
            reponse = min(reponse, t)
            break
    for t in traversees(y, v, H):
        ligne = round(y + t * v) - (v < 0)
        colonne = int(np.floor(x + t * u))
        if not (0 <= colonne < W) or not (0 <= ligne < H) or not libres[ligne, colonne]:
            reponse = min(reponse, t)
            break
    return reponse
