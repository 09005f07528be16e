"""An equal number of pairs is cut before its distance is looked at, in a tree gated at each depth."""

from scipy.stats import chi2


def distances2(z, amers, S):
    return np.array([[(m - a) @ np.linalg.inv(s) @ (m - a) for a, s in zip(amers, S)] for m in z])


def associer(z, amers, S, niveau=0.99):
    d = distances2(z, amers, S)
    reponse = [-1] * len(z)
    ordre = sorted((d[i, k], i, k) for i in range(len(z)) for k in range(len(amers)))
    for valeur, i, k in ordre:
        if valeur <= chi2.ppf(niveau, 2) and reponse[i] == -1 and k not in reponse:
            reponse[i] = k
    return reponse


def nouveaux(z, amers, S, niveau=0.99):
    d = distances2(z, amers, S)
    return [i for i in range(len(z)) if d[i].min() > chi2.ppf(niveau, 2)]


class Arbre:
    def __init__(self, z, amers, C, R, niveau):
        self.z, self.amers, self.C, self.R, self.niveau = z, amers, C, R, niveau
        self.record, self.reponse = 0, [-1] * len(z)

    def permise(self, paires):
        h = np.hstack([self.z[i] - self.amers[k] for i, k in paires])
        lignes = np.hstack([[2 * k, 2 * k + 1] for i, k in paires])
        M = self.C[lignes][:, lignes] + np.kron(np.eye(len(paires)), self.R)
        return h @ np.linalg.inv(M) @ h <= chi2.ppf(self.niveau, len(h))

    def explorer(self, i, paires):
        if len(paires) + len(self.z) - i <= self.record:
            return
        if i == len(self.z):
            self.record = len(paires)
            self.reponse = [-1] * len(self.z)
            for mesure, amer in paires:
                self.reponse[mesure] = amer
            return
        for k in range(len(self.amers)):
            suite = paires + [(i, k)]
            if k not in [amer for mesure, amer in paires] and self.permise(suite):
                self.explorer(i + 1, suite)
        self.explorer(i + 1, paires)


def associer_ensemble(z, amers, C, R, niveau=0.99):
    arbre = Arbre(z, amers, C, R, niveau)
    arbre.explorer(0, [])
    return arbre.reponse
