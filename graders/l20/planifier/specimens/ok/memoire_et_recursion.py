"""A queue without priorities, in which a cell comes again when its price falls; the way back by recursion."""

from collections import deque

from scipy.ndimage import binary_dilation


def gonfler(grille, rayon, resolution):
    n = int(rayon // resolution) + 1
    a = np.arange(-n, n + 1) * resolution
    disque = a[:, None] ** 2 + a[None, :] ** 2 <= rayon**2
    return (grille == 0) & ~binary_dilation(grille == 100, structure=disque)


def cout(chemin, couts):
    total = 0.0
    i = 1
    while i < len(chemin):
        a, b = tuple(chemin[i - 1]), tuple(chemin[i])
        total += np.linalg.norm(np.subtract(a, b)) * (1.0 + 0.5 * couts[a] + 0.5 * couts[b])
        i += 1
    return total


def planifier(permises, couts, depart, but):
    h, w = permises.shape
    bord = np.zeros((h + 2, w + 2), dtype=bool)
    bord[1:-1, 1:-1] = permises
    if not bord[depart[0] + 1, depart[1] + 1] or not bord[but[0] + 1, but[1] + 1]:
        return []
    prix = np.full((h, w), np.inf)
    prix[depart] = 0
    parents = {}
    file = deque([depart])
    while file:
        i, j = file.popleft()
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                if not (bord[i + di + 1, j + dj + 1] and bord[i + 1, j + dj + 1] and bord[i + di + 1, j + 1]):
                    continue
                v = i + di, j + dj
                nouveau = prix[i, j] + cout([(i, j), v], couts)
                if nouveau < prix[v] - 1e-13:
                    prix[v] = nouveau
                    parents[v] = i, j
                    file.append(v)

    def remonter(case):
        return [case] if case == depart else [*remonter(parents[case]), case]

    return remonter(but) if np.isfinite(prix[but]) else []
