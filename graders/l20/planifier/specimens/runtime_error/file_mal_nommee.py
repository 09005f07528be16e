def gonfler(grille, rayon, resolution):
    return grille == 0


def cout(chemin, couts):
    return sum(couts[case] for case in chemin) / len(couts[0][0])


def planifier(permises, couts, depart, but):
    file = [(0.0, depart)]
    while file:
        f, case = heappop(file)
    return []
