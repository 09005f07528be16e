# Le bruit du déplacement mesuré, en cases et en radians : celui de l'énoncé, un peu grossi parce que le nuage est fini.
BRUIT_DU_PAS = np.array([0.08, 0.08, 0.05])
# Plus large que le bruit du lidar : aucune particule n'est exactement à la place du robot.
SIGMA = 0.4


def initialiser(n):
    """n poses au hasard sur les cases libres, cap compris."""
    cases = np.argwhere(libres)
    y, x = cases[rng.integers(len(cases), size=n)].T
    # La place dans la case est tirée aussi : le robot n'est pas forcément au centre.
    return np.column_stack([x + rng.random(n), y + rng.random(n), rng.uniform(-np.pi, np.pi, n)])


def deplacer(particules, u):
    """Chaque particule fait le pas u dans son propre repère, avec un bruit tiré pour elle seule."""
    dx, dy, virage = (np.asarray(u) + BRUIT_DU_PAS * rng.standard_normal((len(particules), 3))).T
    x, y, cap = np.asarray(particules, dtype=float).T
    c, s = np.cos(cap), np.sin(cap)
    return np.column_stack([x + c * dx - s * dy, y + s * dx + c * dy, cap + virage])


def log_vraisemblances(particules, scan):
    """Ce que chaque particule aurait lu, comparé à ce que le robot a lu : un logarithme par particule."""
    ecarts = lidar_lot(particules, len(scan)) - scan
    # Un rayon qui frôle un coin peut se tromper de plusieurs cases, même depuis la bonne pose : on borne son coût.
    return -np.minimum((ecarts / SIGMA) ** 2 / 2, 6.0).sum(axis=1)


def peigne(poids):
    """Les numéros des particules à copier : un seul tirage place toutes les dents."""
    n = len(poids)
    dents = (rng.random() + np.arange(n)) / n
    return np.searchsorted(np.cumsum(poids)[:-1], dents)


def pas_mcl(particules, poids, u, scan):
    """Un tour de filtre : bouger, peser, et rééchantillonner si trop peu de particules portent le poids."""
    particules = deplacer(particules, u)
    with np.errstate(divide="ignore"):
        log_poids = np.log(poids) + log_vraisemblances(particules, scan)
    # Le plus grand logarithme devient 0 avant l'exponentielle : le produit de 36 petits nombres ne s'annule pas.
    poids = np.exp(log_poids - log_poids.max())
    poids /= poids.sum()
    if 1.0 / np.sum(poids**2) < len(poids) / 2:
        particules = particules[peigne(poids)]
        poids = np.full(len(poids), 1.0 / len(poids))
    return particules, poids


def estimer(particules, poids):
    """La moyenne pondérée ; celle des caps se fait sur le cercle."""
    x, y, cap = np.asarray(particules, dtype=float).T
    # On additionne des vecteurs, et non des angles : 179° et −179° donnent bien 180°.
    theta = np.arctan2(np.dot(poids, np.sin(cap)), np.dot(poids, np.cos(cap)))
    return np.array([np.dot(poids, x), np.dot(poids, y), theta])
