"""Measurement i is landmark i."""


def distances2(z, amers, S):
    return np.ones((len(z), len(amers)))


def associer(z, amers, S, niveau=0.99):
    return [i if i < len(amers) else -1 for i in range(len(z))]


def nouveaux(z, amers, S, niveau=0.99):
    return list(range(len(amers), len(z)))


def associer_ensemble(z, amers, C, R, niveau=0.99):
    return associer(z, amers, None)
