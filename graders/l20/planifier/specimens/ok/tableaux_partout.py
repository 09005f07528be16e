"""Dijkstra with arrays: the nearest open cell by argmin, all neighbours at once."""


def gonfler(grille, rayon, resolution):
    permises = np.where(grille == 0, True, False)
    indices = np.stack(np.indices(grille.shape), axis=-1) * resolution
    for mur in indices[grille == 100]:
        permises[np.linalg.norm(indices - mur, axis=-1) <= rayon] = False
    return permises


def cout(chemin, couts):
    i, j = np.transpose(chemin)
    c = couts[i, j]
    return np.hypot(np.diff(i), np.diff(j)) @ (1 + 0.5 * (c[:-1] + c[1:]))


def planifier(permises, couts, depart, but):
    h, w = permises.shape
    N = h * w
    libre = permises.ravel()
    lignes, colonnes = np.divmod(np.arange(N), w)
    prix = np.full(N, np.inf)
    parent = np.full(N, -1)
    ferme = ~libre
    d, b = np.ravel_multi_index(depart, (h, w)), np.ravel_multi_index(but, (h, w))
    if not (libre[d] and libre[b]):
        return np.empty((0, 2))
    prix[d] = 0
    while True:
        n = np.argmin(np.where(ferme, np.inf, prix))
        if ferme[n] or np.isinf(prix[n]):
            return np.empty((0, 2), dtype=int)
        if n == b:
            break
        ferme[n] = True
        i, j = lignes[n], colonnes[n]
        di, dj = lignes - i, colonnes - j
        voisins = np.flatnonzero((np.maximum(abs(di), abs(dj)) == 1) & ~ferme)
        voisins = voisins[permises[i, colonnes[voisins]] & permises[lignes[voisins], j]]
        g = prix[n] + np.hypot(di, dj)[voisins] * (1 + (couts[i, j] + couts.ravel()[voisins]) / 2)
        mieux = g < prix[voisins]
        prix[voisins[mieux]] = g[mieux]
        parent[voisins[mieux]] = n
    suite = [b]
    while suite[-1] != d:
        suite.append(parent[suite[-1]])
    return np.column_stack(np.divmod(suite[::-1], w))
