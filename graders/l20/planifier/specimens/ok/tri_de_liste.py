"""No heap: a list that is sorted at every turn; whole paths wait in it."""

import math


def gonfler(grille, rayon, resolution):
    resultat = []
    hauteur, largeur = grille.shape
    murs = [(i, j) for i in range(hauteur) for j in range(largeur) if grille[i][j] == 100]
    for i in range(hauteur):
        ligne = []
        for j in range(largeur):
            bon = grille[i][j] == 0
            for a, b in murs:
                if math.dist((i * resolution, j * resolution), (a * resolution, b * resolution)) <= rayon:
                    bon = False
                    break
            ligne.append(bool(bon))
        resultat.append(ligne)
    return resultat


def cout(chemin, couts):
    s = 0
    for k in range(len(chemin)):
        if k == 0:
            continue
        a, b = chemin[k - 1], chemin[k]
        if a[0] != b[0] and a[1] != b[1]:
            s += math.sqrt(2) + math.sqrt(2) * (couts[a[0]][a[1]] + couts[b[0]][b[1]]) / 2
        else:
            s += 1 + (couts[a[0]][a[1]] + couts[b[0]][b[1]]) / 2
    return s


def planifier(permises, couts, depart, but):
    if permises[depart] == False or permises[but] == False:  # noqa: E712
        return []
    attente = [(0, [depart])]
    fini = []
    while len(attente) > 0:
        attente.sort(key=lambda t: t[0], reverse=True)
        prix, chemin = attente.pop()
        i, j = chemin[-1]
        if (i, j) == but:
            return chemin
        if (i, j) in fini:
            continue
        fini.append((i, j))
        for di, dj in [(0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)]:
            y = i + di
            x = j + dj
            if y < 0 or x < 0 or y >= len(permises) or x >= len(permises[0]):
                continue
            if permises[y][x] and permises[i][x] and permises[y][j] and (y, x) not in fini:
                attente.append((prix + cout([(i, j), (y, x)], couts), chemin + [(y, x)]))
    return []
