"""Plain loops, recursion for the hypotheses."""
from scipy.stats import chi2


def distances2(z, amers, S):
    D = np.zeros((len(z), len(amers)))
    for i in range(len(z)):
        for k in range(len(amers)):
            e = z[i] - amers[k]
            D[i, k] = e @ np.linalg.inv(S[k]) @ e
    return D


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    choix = [-1] * len(z)
    while True:
        meilleure = None
        for i in range(len(z)):
            for k in range(len(amers)):
                libre = choix[i] == -1 and k not in choix
                if libre and D[i, k] <= chi2.ppf(niveau, 2) and (meilleure is None or D[i, k] < D[meilleure]):
                    meilleure = (i, k)
        if meilleure is None:
            return choix
        choix[meilleure[0]] = meilleure[1]


def nouveaux(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    sortie = []
    for i in range(len(z)):
        connue = False
        for k in range(len(amers)):
            if D[i, k] < chi2.ppf(niveau, 2):
                connue = True
        if not connue:
            sortie.append(i)
    return sortie


def associer_ensemble(z, amers, C, R, niveau=0.99):
    m = len(z)
    meilleur = ([-1] * m, 0, 0.0)

    def essayer(i, choix):
        nonlocal meilleur
        if i == m:
            n = sum(k >= 0 for k in choix)
            if n == 0:
                return
            h, lignes = [], []
            for j, k in enumerate(choix):
                if k >= 0:
                    h += [z[j, 0] - amers[k, 0], z[j, 1] - amers[k, 1]]
                    lignes += [2 * k, 2 * k + 1]
            M = C[lignes][:, lignes].copy()
            for p in range(n):
                M[2 * p : 2 * p + 2, 2 * p : 2 * p + 2] += R
            d = np.array(h) @ np.linalg.inv(M) @ np.array(h)
            if d <= chi2.ppf(niveau, 2 * n) and (n > meilleur[1] or n == meilleur[1] and d < meilleur[2]):
                meilleur = (choix, n, d)
            return
        for k in range(-1, len(amers)):
            if k < 0 or k not in choix:
                essayer(i + 1, choix + [k])

    essayer(0, [])
    return meilleur[0]
