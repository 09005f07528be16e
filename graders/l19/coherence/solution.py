from scipy.stats import chi2


def nees(vraie, estimee, P):
    """Le carré de l'erreur, rapporté au doute que le filtre annonce."""
    e = vraie - estimee
    # En dimension 1 : e² / P. La même erreur est grave si le filtre se disait sûr, et attendue sinon.
    return e @ np.linalg.inv(P) @ e


def bande(n, N, niveau=0.95):
    """Où doit tomber la moyenne de N NEES d'un filtre cohérent de dimension n."""
    # La somme des N NEES suit une loi du khi-deux à n N degrés de liberté ; la moyenne, N fois moins.
    # On laisse de côté la moitié du reste de chaque côté : trop petit est aussi mauvais signe que trop grand.
    reste = (1 - niveau) / 2
    return chi2.ppf(reste, n * N) / N, chi2.ppf(1 - reste, n * N) / N


def coherence(vraies, estimees, covariances):
    """Le NEES moyen de N essais, et l'avis : 1 trop sûr de lui, -1 trop prudent, 0 cohérent."""
    N, n = vraies.shape
    moyenne = sum(nees(vraies[i], estimees[i], covariances[i]) for i in range(N)) / N
    bas, haut = bande(n, N)
    if moyenne > haut:
        return moyenne, 1
    if moyenne < bas:
        return moyenne, -1
    return moyenne, 0
