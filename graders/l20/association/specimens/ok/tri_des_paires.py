"""Pairs sorted once, then taken in their order; combinations by size, the largest first."""
from itertools import combinations, permutations

from scipy.special import chdtri


def distances2(z, amers, S):
    return np.array([[(u - a) @ np.linalg.solve(P, u - a) for a, P in zip(amers, S)] for u in z])


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    paires = sorted((D[i, k], i, k) for i in range(len(z)) for k in range(len(amers)))
    donnes = {}
    for d, i, k in paires:
        if d <= chdtri(2, 1 - niveau) and i not in donnes and k not in donnes.values():
            donnes[i] = k
    return [donnes.get(i, -1) for i in range(len(z))]


def nouveaux(z, amers, S, niveau=0.99):
    return tuple(i for i, ligne in enumerate(distances2(z, amers, S)) if min(ligne) > chdtri(2, 1 - niveau))


def associer_ensemble(z, amers, C, R, niveau=0.99):
    for n in range(min(len(z), len(amers)), 0, -1):
        trouvees = []
        for mesures in combinations(range(len(z)), n):
            for poteaux in permutations(range(len(amers)), n):
                h = np.hstack([z[i] - amers[k] for i, k in zip(mesures, poteaux)])
                J = np.zeros((2 * n, len(C)))
                for p, k in enumerate(poteaux):
                    J[2 * p, 2 * k] = J[2 * p + 1, 2 * k + 1] = 1
                d = h @ np.linalg.inv(J @ C @ J.T + np.kron(np.identity(n), R)) @ h
                if d < chdtri(2 * n, 1 - niveau):
                    trouvees.append((d, mesures, poteaux))
        if trouvees:
            _, mesures, poteaux = min(trouvees)
            paires = dict(zip(mesures, poteaux))
            return [paires.get(i, -1) for i in range(len(z))]
    return [-1] * len(z)
