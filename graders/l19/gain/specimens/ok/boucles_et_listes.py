"""No numpy at all: running sums, lists returned, other parameter names."""


def gain(doute, bruit):
    return doute / (doute + bruit)


def fusionner(valeurs, doutes):
    haut = bas = 0.0
    for i in range(len(valeurs)):
        haut += float(valeurs[i]) / float(doutes[i])
        bas += 1.0 / float(doutes[i])
    return [haut / bas, 1.0 / bas]


def enchainer(moyenne, doute, valeurs, doutes):
    lignes = []
    for i in range(len(valeurs)):
        part = gain(doute, float(doutes[i]))
        moyenne = (1 - part) * moyenne + part * float(valeurs[i])
        doute = doute - part * doute
        lignes.append((moyenne, doute))
    return lignes
