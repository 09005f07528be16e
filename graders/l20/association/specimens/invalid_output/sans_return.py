def distances2(z, amers, S):
    D = np.zeros((len(z), len(amers)))


def associer(z, amers, S, niveau=0.99):
    print("aucun")


def nouveaux(z, amers, S, niveau=0.99):
    pass


def associer_ensemble(z, amers, C, R, niveau=0.99):
    choix = [-1] * len(z)
