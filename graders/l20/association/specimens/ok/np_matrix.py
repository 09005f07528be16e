import itertools

from scipy.stats import chi2


def distances2(z, amers, S):
    D = np.matrix(np.zeros((len(z), len(amers))))
    for i, k in itertools.product(range(len(z)), range(len(amers))):
        e = np.matrix(z[i] - amers[k]).T
        D[i, k] = (e.T * np.matrix(S[k]).I * e).item()
    return D


def associer(z, amers, S, niveau=0.99):
    D = np.asarray(distances2(z, amers, S))
    gamma = chi2.ppf(niveau, 2)
    choix = [-1.0] * len(z)
    for _ in range(len(z)):
        candidats = [
            (D[i, k], i, k)
            for i in range(len(z))
            for k in range(len(amers))
            if choix[i] < 0 and k not in choix and D[i, k] < gamma
        ]
        if candidats:
            _, i, k = min(candidats)
            choix[i] = float(k)
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    D = np.asarray(distances2(z, amers, S))
    return [float(i) for i in range(D.shape[0]) if D[i].min() >= chi2.ppf(niveau, 2)]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    C, R = np.matrix(C), np.matrix(R)
    gagnants = [(0, 0.0, (-1,) * len(z))]
    for choix in itertools.product([-1, *range(len(amers))], repeat=len(z)):
        k = [c for c in choix if c > -1]
        if k and len(k) == len(set(k)):
            h = np.matrix(np.concatenate([z[i] - amers[c] for i, c in enumerate(choix) if c > -1])).T
            r = sorted(range(2 * len(k)), key=lambda x: x)
            lignes = [2 * k[x // 2] + x % 2 for x in r]
            M = C[lignes][:, lignes]
            for p in range(len(k)):
                M[2 * p : 2 * p + 2, 2 * p : 2 * p + 2] += R
            d = (h.T * M.I * h).item()
            if d <= chi2.ppf(niveau, 2 * len(k)):
                gagnants.append((-len(k), d, choix))
    return list(sorted(gagnants)[0][2])
