"""No chance at all: the missing copies go to the largest remainders."""


def n_eff(poids):
    return 1 / np.sum(poids**2)


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    copies = np.floor(n * poids + 1e-9).astype(int)
    ordre = np.argsort(copies - n * poids)
    copies[ordre[: n - copies.sum()]] += 1
    return np.repeat(particules, copies, axis=0)
