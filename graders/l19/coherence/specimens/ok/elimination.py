"""No matrix library: Gauss's elimination on lists, chi2 from scipy for the quantiles alone."""
from scipy.stats import chi2


def resout(A, b):
    n = len(b)
    M = [list(map(float, A[i])) + [float(b[i])] for i in range(n)]
    for c in range(n):
        for i in range(c + 1, n):
            f = M[i][c] / M[c][c]
            M[i] = [u - f * w for u, w in zip(M[i], M[c])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (M[i][n] - sum(M[i][j] * x[j] for j in range(i + 1, n))) / M[i][i]
    return x


def nees(vraie, estimee, P):
    e = [float(a) - float(b) for a, b in zip(vraie, estimee)]
    return sum(a * b for a, b in zip(e, resout(P, e)))


def bande(n, N, niveau=0.95):
    reste = (1 - niveau) / 2
    return [float(chi2.ppf(reste, n * N)) / N, float(chi2.ppf(1 - reste, n * N)) / N]


def coherence(vraies, estimees, covariances):
    total = 0
    for i, vraie in enumerate(vraies):
        total += nees(vraie, estimees[i], covariances[i])
    moyenne = total / len(vraies)
    bas, haut = bande(len(vraies[0]), len(vraies))
    if moyenne > haut:
        avis = +1
    elif moyenne >= bas:
        avis = 0
    else:
        avis = -1
    return moyenne, avis
