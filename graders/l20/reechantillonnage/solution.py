def n_eff(poids):
    """Le nombre effectif de particules, 1 / Σ wᵢ² : entre 1 (un seul poids non nul) et N (poids égaux)."""
    poids = np.asarray(poids)
    return 1.0 / np.sum(poids**2)


def reechantillonner_systematique(particules, poids):
    """N particules copiées avec un peigne de N dents régulières, décalé d'une seule valeur aléatoire."""
    N = len(poids)
    # Les particules se partagent le segment [0, 1] : la particule i finit en cumul[i] et sa longueur est poids[i].
    cumul = np.cumsum(poids)
    # La somme calculée peut valoir 0,9999999999999999 : sans cette ligne, la dernière dent pourrait sortir du segment.
    cumul[-1] = 1.0
    # Un seul tirage décale tout le peigne ; deux dents voisines sont toujours à 1/N l'une de l'autre.
    decalage = rng.random()
    dents = (np.arange(N) + decalage) / N
    # Pour chaque dent, la première particule dont le cumul atteint la dent.
    indices = np.searchsorted(cumul, dents)
    # L'indexation par un tableau d'indices fabrique des copies : l'original reste intact.
    return particules[indices]
