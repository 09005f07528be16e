from mes_fonctions import reechantillonner_systematique

# Les écarts-types du déplacement mesuré, ceux de l'énoncé : en cases, et en radians.
BRUIT = np.array([0.05, 0.05, 0.03])
# Plus large que le bruit du lidar, 0,1 case : aucune particule n'est exactement à la place du robot.
SIGMA = 0.5


def initialiser(n):
    """n poses au hasard sur les cases libres, cap compris."""
    cases = np.argwhere(libres)  # des lignes (y, x)
    y, x = cases[rng.integers(len(cases), size=n)].T
    # La place dans la case est tirée aussi : le robot n'est pas forcément au centre.
    return np.column_stack([x + rng.random(n), y + rng.random(n), rng.uniform(-np.pi, np.pi, n)])


def deplacer(particules, u):
    """Chaque particule fait le pas u dans son propre repère, avec un bruit tiré pour elle seule."""
    dx, dy, virage = (u + rng.normal(0, BRUIT, particules.shape)).T
    x, y, cap = particules.T
    c, s = np.cos(cap), np.sin(cap)
    return np.column_stack([x + c * dx - s * dy, y + s * dx + c * dy, cap + virage])


def vraisemblances(particules, scan):
    """Pour chaque particule, à un facteur près : a-t-on des chances de lire ce scan depuis sa pose ?"""
    ecarts = (scan - lidar_lot(particules, 36)) / SIGMA
    l = -np.sum(ecarts**2, axis=1) / 2
    # Le plus grand logarithme devient 0 avant l'exponentielle : le produit de 36 petits nombres s'annulerait.
    return np.exp(l - l.max())


def un_pas(particules, poids, u, scan):
    """Un tour de filtre : bouger, peser, rééchantillonner."""
    particules = deplacer(particules, u)
    poids = poids * vraisemblances(particules, scan)
    poids = poids / poids.sum()
    # À chaque pas, c'est le plus simple : les copies se partagent le poids, leur nombre dit ce que l'on a appris.
    return reechantillonner_systematique(particules, poids), np.full(len(poids), 1 / len(poids))


def pas_mcl(particules, poids, u, scan):
    """Le pas de la MCL, puis l'injection : une pose que personne n'occupe ne gagnerait jamais."""
    particules, poids = un_pas(particules, poids, u, scan)
    # Une particule sur dix est semée de nouveau, n'importe où. Leurs places sont tirées au hasard : les dernières
    # seraient toujours les copies des mêmes particules.
    semees = rng.choice(len(particules), len(particules) // 10)
    particules[semees] = initialiser(len(semees))
    # Elles gardent leur poids : si l'une explique le prochain scan, ses copies prendront la place des autres.
    return particules, poids


def estimer(particules, poids):
    """La moyenne pondérée ; celle des caps se fait sur le cercle."""
    x, y, cap = particules.T
    # On additionne des vecteurs, et non des angles : 179° et −179° donnent bien 180°.
    theta = np.arctan2(np.sum(poids * np.sin(cap)), np.sum(poids * np.cos(cap)))
    return np.array([np.sum(poids * x), np.sum(poids * y), theta])
