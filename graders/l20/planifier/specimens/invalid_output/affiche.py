def gonfler(grille, rayon, resolution):
    print(grille == 0)


def cout(chemin, couts):
    print(len(chemin) - 1)


def planifier(permises, couts, depart, but):
    print([depart, but])
