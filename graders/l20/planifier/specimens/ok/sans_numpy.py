"""Lists and dictionaries alone; a bucket of open cells searched with min."""


def gonfler(grille, rayon, resolution):
    carte = [list(ligne) for ligne in grille]
    sortie = [[valeur == 0 for valeur in ligne] for ligne in carte]
    for a, ligne in enumerate(carte):
        for b, valeur in enumerate(ligne):
            if valeur != 100:
                continue
            for i in range(len(carte)):
                for j in range(len(ligne)):
                    if ((i - a) ** 2 + (j - b) ** 2) ** 0.5 * resolution <= rayon:
                        sortie[i][j] = False
    return sortie


def cout(chemin, couts):
    chemin = list(chemin)
    prix = 0.0
    while len(chemin) > 1:
        (i, j), (y, x) = chemin.pop(), chemin[-1]
        longueur = 2**0.5 if i != y and j != x else 1
        prix += longueur * (1 + (couts[i, j] + couts[y, x]) / 2)
    return prix


def planifier(permises, couts, depart, but):
    sol = permises.tolist()
    cher = couts.tolist()
    haut, large = len(sol), len(sol[0])
    if not sol[depart[0]][depart[1]] or not sol[but[0]][but[1]]:
        return []
    ouvertes = {tuple(depart): (0.0, None)}
    fermees = {}
    while ouvertes:
        case = min(ouvertes, key=lambda c: ouvertes[c][0])
        prix, parent = ouvertes.pop(case)
        fermees[case] = parent
        if case == tuple(but):
            chemin = []
            while case:
                chemin = [case] + chemin
                case = fermees[case]
            return chemin
        i, j = case
        for y in range(i - 1, i + 2):
            for x in range(j - 1, j + 2):
                if y < 0 or x < 0 or y == haut or x == large or (y, x) in fermees:
                    continue
                if sol[y][x] and sol[i][x] and sol[y][j]:
                    longueur = 1.4142135623730951 if (y - i) * (x - j) else 1.0
                    nouveau = prix + longueur * (1 + (cher[i][j] + cher[y][x]) / 2)
                    if nouveau < ouvertes.get((y, x), (float("inf"), None))[0]:
                        ouvertes[y, x] = (nouveau, case)
    return []
