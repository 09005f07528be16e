import heapq
from itertools import pairwise

from scipy.ndimage import distance_transform_edt

PAS = [(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)]


def gonfler(grille, rayon, resolution):
    distance = resolution * distance_transform_edt(grille != 100)
    return (grille == 0) & (distance > rayon)


def cout(chemin, couts):
    total = 0.0
    for a, b in pairwise(chemin):
        longueur = np.hypot(a[0] - b[0], a[1] - b[1])
        total += longueur * (1.0 + (couts[a] + couts[b]) / 2.0)
    return total


def planifier(permises, couts, depart, but):
    libres = {(int(i), int(j)) for i, j in np.argwhere(permises)}
    if depart not in libres:
        return []
    prix, chemins, file = {depart: 0.0}, {depart: [depart]}, [(0.0, depart)]
    while file:
        _, case = heapq.heappop(file)
        if case == but:
            return chemins[case]
        i, j = case
        for di, dj in PAS:
            voisine = (i + di, j + dj)
            if not libres.issuperset([voisine, (i + di, j), (i, j + dj)]):
                continue  # dehors, interdite, ou un coin serait coupé
            g = prix[case] + cout([case, voisine], couts)
            if g < prix.get(voisine, np.inf):
                prix[voisine], chemins[voisine] = g, [*chemins[case], voisine]
                reste = np.hypot(voisine[0] - but[0], voisine[1] - but[1])
                heapq.heappush(file, (g + reste, voisine))
    return []
