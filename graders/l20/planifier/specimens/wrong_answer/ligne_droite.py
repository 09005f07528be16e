def gonfler(grille, rayon, resolution):
    return grille == 0


def cout(chemin, couts):
    return float(len(chemin) - 1)


def planifier(permises, couts, depart, but):
    (i, j), chemin = depart, [depart]
    while (i, j) != but:
        i += (but[0] > i) - (but[0] < i)
        j += (but[1] > j) - (but[1] < j)
        chemin.append((i, j))
    return chemin
