"""Value iteration on a dictionary, then the path that the values dictate."""


def gonfler(grille, rayon, resolution):
    import math

    h, w = len(grille), len(grille[0])
    murs = list(map(tuple, np.argwhere(grille > 0)))
    return [
        [bool(grille[i, j] == 0) and min(math.hypot(i - a, j - b) for a, b in murs) * resolution > rayon
         for j in range(w)]
        for i in range(h)
    ]


cout = lambda chemin, couts: float(  # noqa: E731
    sum(
        (1.0, 2**0.5)[abs(a[0] - b[0]) + abs(a[1] - b[1]) - 1] * (1 + (couts[a[0], a[1]] + couts[b[0], b[1]]) / 2)
        for a, b in zip(chemin, chemin[1:])
    )
)


def planifier(permises, couts, depart, but):
    sol = {tuple(c) for c in np.argwhere(permises).tolist()}
    if depart not in sol or but not in sol:
        return []
    aretes = {}
    for i, j in sol:
        aretes[i, j] = [
            ((i + a, j + b), cout([(i, j), (i + a, j + b)], couts))
            for a in (-1, 0, 1)
            for b in (-1, 0, 1)
            if (a or b) and {(i + a, j + b), (i + a, j), (i, j + b)} <= sol
        ]
    valeur = {c: (0.0 if c == but else float("inf")) for c in sol}
    change = True
    while change:
        change = False
        for c in sol:
            for v, p in aretes[c]:
                if valeur[v] + p < valeur[c]:
                    valeur[c] = valeur[v] + p
                    change = True
    if valeur[depart] == float("inf"):
        return []
    chemin = [depart]
    while chemin[-1] != but:
        chemin += [min(aretes[chemin[-1]], key=lambda e: valeur[e[0]] + e[1])[0]]
    return chemin
