def distances2(z, amers, S):
    return np.zeros((len(z), len(amers)))


def associer(z, amers, S, niveau=0.99)
    return [-1] * len(z)


def nouveaux(z, amers, S, niveau=0.99):
    return []


def associer_ensemble(z, amers, C, R, niveau=0.99):
    return [-1] * len(z)
