from collections import namedtuple

from scipy import stats

Paire = namedtuple("Paire", "d i k")


def distances2(z, amers, S):
    return np.vstack([np.diag(E @ np.linalg.inv(P) @ E.T) for E, P in ((z - a, P) for a, P in zip(amers, S))]).T


def toutes(z, amers, S):
    for (i, k), d in np.ndenumerate(distances2(z, amers, S)):
        yield Paire(d, i, k)


def associer(z, amers, S, niveau=0.99):
    restent = [p for p in toutes(z, amers, S) if p.d <= stats.chi2.ppf(niveau, 2)]
    choix = {}
    while restent:
        p = min(restent)
        choix[p.i] = p.k
        restent = [q for q in restent if q.i != p.i and q.k != p.k]
    return [choix.get(i, -1) for i in range(len(z))]


def nouveaux(z, amers, S, niveau=0.99):
    connues = {p.i for p in toutes(z, amers, S) if p.d <= stats.chi2.ppf(niveau, 2)}
    return sorted(set(range(len(z))) - connues)


def essais(i, m, libres):
    if i == m:
        yield []
    else:
        for suite in essais(i + 1, m, libres):
            yield suite
        for k in libres:
            for suite in essais(i + 1, m, libres - {k}):
                yield [(i, k), *suite]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    def note(p):
        h = np.array([z[i] - amers[k] for i, k in p]).reshape(-1)
        M = np.block([[C[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] + (R if a == b else 0 * R) for _, b in p] for _, a in p])
        return float(h @ np.linalg.pinv(M) @ h)

    meilleure, taille, distance = [], 0, 0.0
    for p in essais(0, len(z), frozenset(range(len(amers)))):
        if len(p) >= max(taille, 1):
            d = note(p)
            if d <= stats.chi2.ppf(niveau, 2 * len(p)) and (len(p) > taille or d < distance):
                meilleure, taille, distance = p, len(p), d
    reponse = np.full(len(z), -1)
    for i, k in meilleure:
        reponse[i] = k
    return reponse
