"""Particles and weights sorted together, heaviest first: another comb, as fair as the first one."""


def n_eff(poids):
    return (sum(poids) ** 2) / sum(p * p for p in poids)


def reechantillonner_systematique(particules, poids):
    ordre = np.argsort(-poids)
    p, w = particules[ordre], poids[ordre]
    n = len(w)
    decalage = np.random.uniform() / n
    resultat = np.zeros(p.shape)
    cumul, i = w[0], 0
    for m in range(n):
        while decalage + m / n > cumul:
            i += 1
            cumul += w[i]
        resultat[m] = p[i]
    return resultat
