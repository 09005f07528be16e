"""Right copies in a shuffled order, as a tuple of rows; N_eff by a scalar product, after normalising once more."""
from l20 import np, rng


def n_eff(poids):
    poids = np.array(poids) / np.sum(poids)
    return np.array(1.0 / np.dot(poids, poids))


def reechantillonner_systematique(particules, poids):
    n = particules.shape[0]
    dents = np.linspace(0.0, 1.0, n, endpoint=False) + rng.uniform(0.0, 1.0 / n)
    choix = np.digitize(dents, np.cumsum(poids))
    rng.shuffle(choix)
    return tuple(particules[min(k, n - 1)] for k in choix)
