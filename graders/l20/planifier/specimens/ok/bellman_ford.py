"""Prices of all cells at once, relaxed until nothing changes; then down the slope from the goal."""

HUIT = [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b]


def gonfler(grille, rayon, resolution):
    sorties = grille == 0
    portee = int(np.ceil(rayon / resolution)) + 1
    murs = np.pad(grille == 100, portee)
    h, w = grille.shape
    for di in range(-portee, portee + 1):
        for dj in range(-portee, portee + 1):
            if resolution * np.hypot(di, dj) <= rayon:
                sorties = sorties & ~murs[portee + di : portee + di + h, portee + dj : portee + dj + w]
    return sorties


def cout(chemin, couts):
    cases = np.array(chemin)
    c = couts[cases[:, 0], cases[:, 1]]
    longueurs = np.linalg.norm(np.diff(cases, axis=0), axis=1)
    return np.sum(longueurs * (1 + (c[1:] + c[:-1]) / 2))


def decale(tableau, di, dj, reste):
    h, w = tableau.shape
    grand = np.pad(tableau, 1, constant_values=reste)
    return grand[1 + di : 1 + di + h, 1 + dj : 1 + dj + w]


def planifier(permises, couts, depart, but):
    if not permises[depart] or not permises[but]:
        return []
    prix = np.full(permises.shape, np.inf)
    prix[depart] = 0.0
    pas = {}
    for di, dj in HUIT:
        ouvert = permises & decale(permises, di, dj, False)
        ouvert &= decale(permises, di, 0, False) & decale(permises, 0, dj, False)
        montant = np.hypot(di, dj) * (1 + (couts + decale(couts, di, dj, 0.0)) / 2)
        pas[di, dj] = np.where(ouvert, montant, np.inf)
    while True:
        nouveau = prix
        for (di, dj), montant in pas.items():
            nouveau = np.minimum(nouveau, decale(nouveau, di, dj, np.inf) + montant)
        if np.array_equal(nouveau, prix):
            break
        prix = nouveau
    if np.isinf(prix[but]):
        return []
    chemin, case = [but], but
    while case != depart:
        i, j = case
        case = min(
            ((i + di, j + dj) for di, dj in HUIT if np.isfinite(pas[di, dj][i, j])),
            key=lambda v: prix[v] + pas[v[0] - i, v[1] - j][i, j],
        )
        chemin.append(case)
    chemin.reverse()
    return chemin
