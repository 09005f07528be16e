class Peigne:
    def __init__(self, n, decalage):
        self.n, self.decalage = n, decalage

    def dents_sous(self, longueur):
        """How many teeth stand strictly below a length of [0, 1]."""
        return int(min(max(np.ceil(longueur * self.n - self.decalage), 0), self.n))


def n_eff(poids):
    return np.float64(1) / np.vdot(poids, poids)


def reechantillonner_systematique(particules, poids):
    peigne = Peigne(len(poids), rng.random())
    sortie, avant, cumul = [], 0, 0.0
    for k, (ligne, p) in enumerate(zip(particules, poids)):
        cumul += p
        apres = peigne.n if k == len(poids) - 1 else peigne.dents_sous(cumul)
        sortie.extend([ligne] * (apres - avant))
        avant = apres
    return np.stack(sortie)
