import numpy as numerique
from scipy.stats import chi2


def distances2(z, amers, S):
    e = numerique.subtract.outer(z, amers)[:, [0, 1], :, [0, 1]]
    e = numerique.moveaxis(e, 0, -1)
    return numerique.sum(e * numerique.matmul(numerique.linalg.inv(S), e[..., None])[..., 0], axis=-1)


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    table = numerique.array(
        [(D[i, k], i, k) for i in range(D.shape[0]) for k in range(D.shape[1])],
        dtype=[("d", float), ("i", int), ("k", int)],
    )
    table = table[table["d"] <= chi2.ppf(niveau, 2)]
    choix = numerique.full(len(z), -1)
    while len(table):
        premier = table[table["d"].argmin()]
        choix[premier["i"]] = premier["k"]
        table = table[(table["i"] != premier["i"]) & (table["k"] != premier["k"])]
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    return [i for i in range(len(z)) if (distances2(z[i : i + 1], amers, S) > chi2.ppf(niveau, 2)).all()]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    grille = numerique.array(numerique.meshgrid(*[range(-1, len(amers))] * len(z))).reshape(len(z), -1).T
    meilleur, note = grille[0], (0.0, 0.0)
    for choix in grille:
        i = numerique.flatnonzero(choix + 1)
        k = choix[i]
        if len(i) == 0 or len(numerique.unique(k)) < len(k):
            continue
        r = (2 * k[:, None] + [0, 1]).ravel()
        h = (z[i] - amers[k]).ravel()
        d = h @ numerique.linalg.inv(C[r[:, None], r] + numerique.kron(numerique.eye(len(i)), R)) @ h
        if d <= chi2.ppf(niveau, len(h)) and (len(i) > note[0] or (len(i) == note[0] and d < note[1])):
            meilleur, note = choix, (len(i), d)
    return meilleur if note[0] else numerique.full(len(z), -1)
