# Un histogramme compté avec des boucles, et la somme des écarts absolus.
LARGEUR = 1.0


def signature(z):
    cases = [0] * 13
    for d in z:
        cases[min(int(d / LARGEUR), 12)] += 1
    return cases


def candidats_boucle(mesures, numero, tolerance):
    s = signature(mesures[numero])
    trouves = []
    j = 0
    while j <= numero - 10:
        ecart = 0
        for a, b in zip(signature(mesures[j]), s):
            ecart += abs(a - b)
        if ecart < tolerance:
            trouves.append(j)
        j += 1
    print("candidats", trouves)
    return tuple(trouves)
