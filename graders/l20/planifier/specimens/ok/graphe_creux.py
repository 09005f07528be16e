"""scipy's own Dijkstra on a sparse graph."""

from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree


def gonfler(grille, rayon, resolution):
    murs = np.argwhere(grille == 100)
    cases = np.argwhere(np.ones(grille.shape, dtype=bool))
    distances, _ = cKDTree(murs * resolution).query(cases * resolution)
    return (distances.reshape(grille.shape) > rayon) & (grille == 0)


def cout(chemin, couts):
    prix = 0
    precedente = None
    for case in chemin:
        if precedente is not None:
            droit = precedente[0] == case[0] or precedente[1] == case[1]
            prix += (1 if droit else np.sqrt(2)) * (1 + np.mean([couts[tuple(precedente)], couts[tuple(case)]]))
        precedente = case
    return prix


def planifier(permises, couts, depart, but):
    h, w = permises.shape
    if not (permises[depart] and permises[but]):
        return []
    lignes, colonnes, valeurs = [], [], []
    for i in range(h):
        for j in range(w):
            for y, x in ((i, j + 1), (i + 1, j), (i + 1, j + 1), (i + 1, j - 1)):
                if not (0 <= y < h and 0 <= x < w):
                    continue
                if permises[min(i, y) : max(i, y) + 1, min(j, x) : max(j, x) + 1].all():
                    lignes.append(i * w + j)
                    colonnes.append(y * w + x)
                    valeurs.append(cout([(i, j), (y, x)], couts))
    graphe = csr_matrix((valeurs, (lignes, colonnes)), shape=(h * w, h * w))
    source, cible = depart[0] * w + depart[1], but[0] * w + but[1]
    distances, avant = dijkstra(graphe, directed=False, indices=source, return_predecessors=True)
    if np.isinf(distances[cible]):
        return []
    chemin = [cible]
    while chemin[-1] != source:
        chemin.append(int(avant[chemin[-1]]))
    return np.array([[n // w, n % w] for n in reversed(chemin)])
