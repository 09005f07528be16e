L_OCC = np.log(0.7 / 0.3)
L_LIBRE = np.log(0.3 / 0.7)


def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def case(x, y):
    return int(np.floor(y)), int(np.floor(x))


def traversees(x, y, angle, longueur):
    cosinus, sinus = np.cos(angle), np.sin(angle)
    bornes = [0.0, longueur]
    for depart, pente in ((x, cosinus), (y, sinus)):
        if abs(pente) > 1e-9:
            fin = depart + longueur * pente
            lignes = np.arange(np.ceil(min(depart, fin)), np.floor(max(depart, fin)) + 1)
            bornes.extend((lignes - depart) / pente)
    bornes = np.sort(bornes)
    cases = []
    for k in range(len(bornes) - 1):
        debut, fin = bornes[k], bornes[k + 1]
        milieu = (debut + fin) / 2
        if fin - debut > 1e-9:
            cases.append(case(x + milieu * cosinus, y + milieu * sinus))
    return cases


def dedans(i, j, forme):
    return 0 <= i < forme[0] and 0 <= j < forme[1]


def arret(x, y, angle, z):
    r = z + 1e-6
    return case(x + r * np.cos(angle), y + r * np.sin(angle))


def borner(l):
    return np.clip(l, -5, 5)


def integrer_scan(l, pose, scan, portee_max):
    x, y, theta = pose
    nouvelle = np.array(l, dtype=float)
    n = len(scan)
    for k in range(n):
        z = scan[k]
        angle = theta + 2 * np.pi * k / n
        touche = z < portee_max
        longueur = min(z, portee_max)
        mur = arret(x, y, angle, z)
        libre = traversees(x, y, angle, longueur)
        for i, j in libre:
            if dedans(i, j, l.shape) and not (touche and (i, j) == mur):
                nouvelle[i, j] += L_LIBRE
        if touche and dedans(mur[0], mur[1], l.shape):
            nouvelle[mur] += L_OCC
    return borner(nouvelle)
