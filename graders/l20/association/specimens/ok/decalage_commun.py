"""The common error written as an unknown that is marginalised: C by its square root."""
from itertools import product

from scipy.stats import chi2


def distances2(z, amers, S):
    sortie = []
    for p in z:
        valeurs, vecteurs = np.linalg.eigh(S)
        composantes = np.einsum("kij,ki->kj", vecteurs, p - amers)
        sortie.append(np.sum(composantes**2 / valeurs, axis=1))
    return sortie


def associer(z, amers, S, niveau=0.99):
    D = np.array(distances2(z, amers, S))
    choix = np.full(len(z), -1)
    mesures, poteaux = np.arange(len(z)), np.arange(len(amers))
    while D.size and D.min() <= chi2.ppf(niveau, df=2):
        i, k = np.unravel_index(np.argmin(D), D.shape)
        choix[mesures[i]] = poteaux[k]
        D = np.delete(np.delete(D, i, axis=0), k, axis=1)
        mesures, poteaux = np.delete(mesures, i), np.delete(poteaux, k)
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    hors = np.array(distances2(z, amers, S)) > chi2.ppf(niveau, df=2)
    return np.arange(len(z))[np.all(hors, axis=1)]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    valeurs, vecteurs = np.linalg.eigh(C)
    racine = vecteurs * np.sqrt(np.maximum(valeurs, 0))
    Ri = np.linalg.inv(R)
    note = {}
    for choix in product(range(-1, len(amers)), repeat=len(z)):
        p = [(i, k) for i, k in enumerate(choix) if k >= 0]
        if p and len({k for _, k in p}) == len(p):
            # min over x of (h - G x)' W (h - G x) + x' x
            G = np.vstack([racine[2 * k : 2 * k + 2] for _, k in p])
            h = np.concatenate([z[i] - amers[k] for i, k in p])
            W = np.kron(np.eye(len(p)), Ri)
            x = np.linalg.solve(G.T @ W @ G + np.eye(len(C)), G.T @ W @ h)
            d = (h - G @ x) @ W @ (h - G @ x) + x @ x
            if d <= chi2.ppf(niveau, df=2 * len(p)):
                note[choix] = (len(p), -d)
    return list(max(note, key=note.get, default=[-1] * len(z)))
