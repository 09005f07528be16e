def gonfler(grille, rayon, resolution)
    return grille == 0


def cout(chemin, couts):
    return 0.0


def planifier(permises, couts, depart, but):
    return []
