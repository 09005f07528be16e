"""Prices from both ends, everywhere; a cell of a best path is one whose two prices add up to the least."""

import heapq


def distances(permises, couts, depuis):
    h, w = permises.shape
    d = np.full((h, w), np.inf)
    d[depuis] = 0
    tas = [(0.0, depuis)]
    while tas:
        p, (i, j) = heapq.heappop(tas)
        if p > d[i, j]:
            continue
        for y in range(max(i - 1, 0), min(i + 2, h)):
            for x in range(max(j - 1, 0), min(j + 2, w)):
                if permises[y, x] and permises[i, x] and permises[y, j]:
                    q = p + prix(i, j, y, x, couts)
                    if q < d[y, x]:
                        d[y, x] = q
                        heapq.heappush(tas, (q, (y, x)))
    return d


def prix(i, j, y, x, couts):
    return ((i - y) ** 2 + (j - x) ** 2) ** 0.5 * (1 + (couts[i, j] + couts[y, x]) / 2)


def gonfler(grille, rayon, resolution):
    i, j = np.where(grille == 100)
    y, x = np.where(grille == 0)
    loin = np.sqrt(np.subtract.outer(y, i) ** 2 + np.subtract.outer(x, j) ** 2) * resolution
    permises = np.zeros(grille.shape, bool)
    permises[y, x] = (loin > rayon).all(axis=1)
    return permises


def cout(chemin, couts):
    return sum(prix(*a, *b, couts) for a, b in zip(chemin[:-1], chemin[1:]))


def planifier(permises, couts, depart, but):
    if not all(permises[c] for c in (depart, but)):
        return []
    reste = distances(permises, couts, but)
    if reste[depart] == np.inf:
        return []
    chemin = [depart]
    while chemin[-1] != but:
        i, j = chemin[-1]
        candidats = []
        for y in range(max(i - 1, 0), min(i + 2, len(permises))):
            for x in range(max(j - 1, 0), min(j + 2, permises.shape[1])):
                if (y, x) != (i, j) and permises[y, x] and permises[i, x] and permises[y, j]:
                    candidats.append((prix(i, j, y, x, couts) + reste[y, x], y, x))
        _, y, x = min(candidats)
        chemin.append((y, x))
    return chemin
