"""The branch and bound of Neira and Tardós."""
from scipy.stats import chi2


def distances2(z, amers, S):
    D = np.empty((len(z), len(amers)))
    for k, (a, P) in enumerate(zip(amers, S)):
        L = np.linalg.cholesky(P)
        D[:, k] = (np.linalg.solve(L, (z - a).T) ** 2).sum(axis=0)
    return D


def associer(z, amers, S, niveau=0.99):
    D = np.ma.masked_greater(distances2(z, amers, S), chi2.ppf(niveau, 2))
    choix = np.repeat(-1, len(z))
    while D.count():
        i, k = np.unravel_index(D.argmin(), D.shape)
        choix[i] = k
        D[i] = np.ma.masked
        D[:, k] = np.ma.masked
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    portes = distances2(z, amers, S) <= chi2.ppf(niveau, 2)
    return [i for i in range(len(z)) if not portes[i].any()]


class Arbre:
    def __init__(self, z, amers, C, R, niveau):
        self.z, self.amers, self.C, self.R, self.niveau = z, amers, C, R, niveau
        self.meilleur, self.score = [-1] * len(z), (0, 0.0)

    def distance(self, H):
        paires = [(i, k) for i, k in enumerate(H) if k >= 0]
        if not paires:
            return 0, 0.0
        h = np.concatenate([self.z[i] - self.amers[k] for i, k in paires])
        r = np.concatenate([[2 * k, 2 * k + 1] for _, k in paires])
        M = self.C[np.ix_(r, r)] + np.kron(np.eye(len(paires)), self.R)
        return len(paires), float(h @ np.linalg.solve(M, h))

    def descendre(self, H):
        n, d = self.distance(H)
        if n and d > chi2.ppf(self.niveau, 2 * n):
            return
        reste = len(self.z) - len(H)
        if n + reste < self.score[0]:
            return
        if not reste:
            if n > self.score[0] or (n == self.score[0] and d < self.score[1]):
                self.meilleur, self.score = H, (n, d)
            return
        for k in range(len(self.amers)):
            if k not in H:
                self.descendre([*H, k])
        self.descendre([*H, -1])


def associer_ensemble(z, amers, C, R, niveau=0.99):
    arbre = Arbre(z, amers, C, R, niveau)
    arbre.descendre([])
    return arbre.meilleur
