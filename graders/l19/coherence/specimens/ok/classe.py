from scipy.stats import chi2


class Jury:
    def __init__(self, n, N, niveau=0.95):
        reste = 1 - niveau
        self.bas = chi2.ppf(reste / 2, n * N) / N
        self.haut = chi2.isf(reste / 2, n * N) / N

    def avis(self, moyenne):
        if moyenne < self.bas:
            return -1
        return 1 if moyenne > self.haut else 0


def nees(vraie, estimee, P):
    e = (vraie - estimee).reshape(-1, 1)
    return (e.T @ np.linalg.inv(P) @ e).item()


def bande(n, N, niveau=0.95):
    jury = Jury(n, N, niveau)
    return jury.bas, jury.haut


def coherence(vraies, estimees, covariances):
    N, n = vraies.shape
    moyenne = np.average([nees(v, x, P) for v, x, P in zip(vraies, estimees, covariances)])
    return moyenne, Jury(n, N).avis(moyenne)
