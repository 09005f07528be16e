"""The segment is halved until it holds one particle: its teeth are all copies of that one."""


def n_eff(poids):
    return 1.0 / float((np.asarray(poids) ** 2).sum())


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    fins = np.concatenate([[0.0], np.cumsum(poids)])
    fins[-1] = 1.0
    dents = (np.arange(n) + rng.random()) / n
    choisies = []

    def partager(debut, fin, celles):
        if len(celles) == 0:
            return
        if fin - debut == 1:
            choisies.extend([debut] * len(celles))
            return
        milieu = (debut + fin) // 2
        partager(debut, milieu, celles[celles <= fins[milieu]])
        partager(milieu, fin, celles[celles > fins[milieu]])

    partager(0, n, dents)
    return particules[choisies, :]
