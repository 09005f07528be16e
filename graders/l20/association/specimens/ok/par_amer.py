"""From the map's side: who wants me? The deferred offers end at the nearest pairs first."""
from itertools import product

from scipy.stats import chi2


def distances2(z, amers, S):
    inverses = [np.linalg.inv(P) for P in S]
    colonnes = []
    for a, W in zip(amers, inverses):
        dx, dy = z[:, 0] - a[0], z[:, 1] - a[1]
        colonnes.append(W[0, 0] * dx * dx + (W[0, 1] + W[1, 0]) * dx * dy + W[1, 1] * dy * dy)
    return np.array(colonnes).T


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    porte = chi2.ppf(niveau, 2)
    listes = [[k for k in np.argsort(D[i]) if D[i, k] <= porte] for i in range(len(z))]
    tenant, attente = {}, list(range(len(z)))
    while attente:
        i = attente.pop()
        if not listes[i]:
            continue
        k = listes[i].pop(0)
        rival = tenant.get(k)
        if rival is None:
            tenant[k] = i
        elif D[i, k] < D[rival, k]:
            tenant[k] = i
            attente.append(rival)
        else:
            attente.append(i)
    choix = np.full(len(z), -1)
    for k, i in tenant.items():
        choix[i] = k
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    portes = distances2(z, amers, S) <= chi2.ppf(niveau, 2)
    return [i for i, combien in enumerate(portes.sum(axis=1)) if combien == 0]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    essais = []
    for qui in product(range(-1, len(z)), repeat=len(amers)):
        vues = [i for i in qui if i >= 0]
        if len(vues) != len(set(vues)):
            continue
        choix = [-1] * len(z)
        for k, i in enumerate(qui):
            if i >= 0:
                choix[i] = k
        n = len(vues)
        if n:
            r = [2 * k + c for k, i in enumerate(qui) if i >= 0 for c in (0, 1)]
            h = np.concatenate([z[i] - amers[k] for k, i in enumerate(qui) if i >= 0])
            d = h @ np.linalg.solve(C[np.ix_(r, r)] + np.kron(np.eye(n), R), h)
            if d > chi2.ppf(niveau, 2 * n):
                continue
        else:
            d = 0.0
        essais.append((n, -d, choix))
    return max(essais)[2]
