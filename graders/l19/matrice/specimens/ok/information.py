"""Information form: inverses of covariances add up."""


def predire(etat, doute, modele, bruit):
    return modele @ etat, np.linalg.multi_dot([modele, doute, modele.T]) + bruit


def corriger(etat, doute, mesure, vue, bruit):
    avant, capteur = np.linalg.inv(doute), np.linalg.inv(bruit)
    apres = np.linalg.inv(avant + vue.T @ capteur @ vue)
    return apres @ (avant @ etat + vue.T @ capteur @ mesure), apres
