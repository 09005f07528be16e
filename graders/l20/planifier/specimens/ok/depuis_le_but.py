"""Searches from the goal, so that the path comes out the right way round."""

import heapq


def gonfler(grille, rayon, resolution):
    y, x = np.mgrid[: grille.shape[0], : grille.shape[1]]
    murs = np.argwhere(grille == 100)
    carres = (y[..., None] - murs[:, 0]) ** 2 + (x[..., None] - murs[:, 1]) ** 2
    return (grille == 0) & (carres.min(axis=-1) > (rayon / resolution) ** 2)


def cout(chemin, couts):
    if len(chemin) < 2:
        return 0
    (i, j), (y, x) = chemin[0], chemin[1]
    pas = np.sqrt((i - y) ** 2 + (j - x) ** 2)
    return pas + pas * couts[i, j] / 2 + pas * couts[y, x] / 2 + cout(chemin[1:], couts)


def planifier(permises, couts, depart, but):
    permis = {(int(i), int(j)) for i, j in np.argwhere(permises)}
    if not {depart, but} <= permis:
        return []
    vers, attente, clos = {but: (0.0, None)}, [(0.0, but)], set()
    while attente and depart not in clos:
        prix, (i, j) = heapq.heappop(attente)
        if (i, j) in clos:
            continue
        clos.add((i, j))
        for y in (i - 1, i, i + 1):
            for x in (j - 1, j, j + 1):
                if {(y, x), (i, x), (y, j)} <= permis and (y, x) not in clos:
                    total = prix + cout([(i, j), (y, x)], couts)
                    if (y, x) not in vers or total < vers[y, x][0]:
                        vers[y, x] = (total, (i, j))
                        heapq.heappush(attente, (total, (y, x)))
    if depart not in vers:
        return []
    case, chemin = depart, []
    while case is not None:
        chemin.append(case)
        case = vers[case][1]
    return chemin
