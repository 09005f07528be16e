def vers_logodds(p):
    """Le log-odds d'une probabilité ; np.log accepte un nombre comme un tableau."""
    return np.log(p / (1 - p))


def vers_proba(l):
    """La probabilité d'un log-odds."""
    # Pour l très négatif, exp(-l) déborde vers l'infini, et 1 / infini vaut bien 0.
    return 1 / (1 + np.exp(-l))


L_OCC = np.log(0.7 / 0.3)
PETIT_PAS = 1e-6


def cases_du_rayon(x, y, angle, longueur):
    """Les cases (ligne, colonne) que traverse un rayon, dans l'ordre, sans en manquer une (Amanatides et Woo)."""
    i, j = int(np.floor(y)), int(np.floor(x))
    cosinus, sinus = np.cos(angle), np.sin(angle)
    sens_i, sens_j = (1 if sinus > 0 else -1), (1 if cosinus > 0 else -1)
    # Distances, le long du rayon, à la prochaine ligne horizontale et à la prochaine verticale...
    vers_i = (i + (sinus > 0) - y) / sinus if sinus else np.inf
    vers_j = (j + (cosinus > 0) - x) / cosinus if cosinus else np.inf
    # ... puis d'une horizontale à la suivante, d'une verticale à la suivante.
    saut_i = abs(1 / sinus) if sinus else np.inf
    saut_j = abs(1 / cosinus) if cosinus else np.inf
    cases = [(i, j)]
    while min(vers_i, vers_j) < longueur:
        if vers_i < vers_j:
            i, vers_i = i + sens_i, vers_i + saut_i
        else:
            j, vers_j = j + sens_j, vers_j + saut_j
        cases.append((i, j))
    return cases


def integrer_scan(l, pose, scan, portee_max):
    """La grille de log-odds après un scan de plus ; celle qui est donnée reste intacte."""
    x, y, theta = pose
    nouvelle = np.array(l, dtype=float)
    hauteur, largeur = nouvelle.shape
    for k, z in enumerate(scan):
        angle = theta + 2 * np.pi * k / len(scan)
        touche = z < portee_max
        # La case d'arrêt est celle du point situé juste après la distance lue : sur la face du mur, un arrondi
        # donnerait la case d'avant.
        r = z + PETIT_PAS
        arret = (int(np.floor(y + r * np.sin(angle))), int(np.floor(x + r * np.cos(angle))))
        for i, j in cases_du_rayon(x, y, angle, min(z, portee_max)):
            # Un mur peut arrêter le rayon hors de la grille : un indice négatif désignerait l'autre bord.
            if 0 <= i < hauteur and 0 <= j < largeur and (not touche or (i, j) != arret):
                nouvelle[i, j] -= L_OCC
        if touche and 0 <= arret[0] < hauteur and 0 <= arret[1] < largeur:
            nouvelle[arret] += L_OCC
    return np.clip(nouvelle, -5, 5)
