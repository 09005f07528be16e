import heapq


def gonfler(grille, rayon, resolution):
    i, j = np.indices(grille.shape)
    permises = grille == 0
    for a, b in np.argwhere(grille == 100):
        distance = resolution * np.hypot(i - a, j - b)
        permises = permises & (distance > rayon)
    return permises


def prix_du_pas(a, b, couts):
    longueur = np.hypot(b[0] - a[0], b[1] - a[1])
    return longueur * (1 + (couts[a[0], a[1]] + couts[b[0], b[1]]) / 2)


def cout(chemin, couts):
    total = 0.0
    for k in range(len(chemin) - 1):
        total = total + prix_du_pas(chemin[k], chemin[k + 1], couts)
    return total


def estimation(case, but):
    di, dj = abs(case[0] - but[0]), abs(case[1] - but[1])
    return max(di, dj) + (np.sqrt(2) - 1) * min(di, dj)


def voisines(case, permises):
    hauteur, largeur = permises.shape
    trouvees = []
    for di in (-1, 0, 1):
        for dj in (-1, 0, 1):
            i, j = case[0] + di, case[1] + dj
            if di == 0 and dj == 0:
                continue
            if not (0 <= i < hauteur and 0 <= j < largeur):
                continue
            if not permises[i, j]:
                continue
            if not permises[case[0], j] or not permises[i, case[1]]:
                continue
            trouvees.append((i, j))
    return trouvees


def remonter(avant, depart, but):
    chemin = [but]
    while chemin[-1] != depart:
        chemin.append(avant[chemin[-1]])
    return chemin[::-1]


def planifier(permises, couts, depart, but):
    if not permises[depart] or not permises[but]:
        return []
    prix, avant, reglees = {depart: 0.0}, {}, set()
    file = [(estimation(depart, but), depart)]
    while file:
        f, case = heapq.heappop(file)
        if case in reglees:
            continue
        reglees.add(case)
        if case == but:
            return remonter(avant, depart, but)
        for voisine in voisines(case, permises):
            g = prix[case] + prix_du_pas(case, voisine, couts)
            if voisine not in reglees and g < prix.get(voisine, np.inf):
                prix[voisine] = g
                avant[voisine] = case
                heapq.heappush(file, (g + estimation(voisine, but), voisine))
    return []
