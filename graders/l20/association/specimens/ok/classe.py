from scipy.stats import chi2


class Porte:
    def __init__(self, niveau, n=1):
        self.seuil = chi2.ppf(niveau, 2 * n)

    def __contains__(self, d2):
        return d2 <= self.seuil


class Tableau:
    def __init__(self, z, amers, S):
        self.D = np.stack([np.sum((z - a) @ np.linalg.inv(P) * (z - a), axis=1) for a, P in zip(amers, S)], axis=1)

    def paires(self, porte):
        D = self.D.copy()
        while D.size and D.min() in porte:
            i, k = np.argwhere(D == D.min())[0]
            yield i, k
            D[i], D[:, k] = np.inf, np.inf


def distances2(z, amers, S):
    return Tableau(z, amers, S).D


def associer(z, amers, S, niveau=0.99):
    reponse = np.zeros(len(z), dtype=int) - 1
    for i, k in Tableau(z, amers, S).paires(Porte(niveau)):
        reponse[i] = k
    return reponse


def nouveaux(z, amers, S, niveau=0.99):
    porte = Porte(niveau)
    return [i for i, ligne in enumerate(Tableau(z, amers, S).D) if not any(d in porte for d in ligne)]


class Hypothese:
    def __init__(self, choix):
        self.choix = tuple(choix)
        self.mesures = [i for i, k in enumerate(choix) if k >= 0]
        self.poteaux = [k for k in choix if k >= 0]

    def permise(self):
        return len(set(self.poteaux)) == len(self.poteaux) > 0

    def distance(self, z, amers, C, R):
        h = z[self.mesures] - amers[self.poteaux]
        n, l = len(self.mesures), len(amers)
        blocs = C.reshape(l, 2, l, 2)[self.poteaux][:, :, self.poteaux].reshape(2 * n, 2 * n)
        return h.ravel() @ np.linalg.inv(blocs + np.kron(np.eye(n), R)) @ h.ravel()


def associer_ensemble(z, amers, C, R, niveau=0.99):
    base = len(amers) + 1
    meilleure, score = Hypothese([-1] * len(z)), (0, 0)
    for numero in range(base ** len(z)):
        H = Hypothese([numero // base**i % base - 1 for i in range(len(z))])
        if H.permise():
            d, n = H.distance(z, amers, C, R), len(H.mesures)
            if d in Porte(niveau, n) and (n, -d) > score:
                meilleure, score = H, (n, -d)
            elif score == (0, 0) and d in Porte(niveau, n):
                meilleure, score = H, (n, -d)
    return meilleure.choix
