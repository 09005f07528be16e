from scipy import stats


def nees(vraie, estimee, P):
    e = np.matrix(vraie - estimee).T
    return (e.T * np.matrix(P).I * e)[0, 0]


def bande(n, N, niveau=0.95):
    marge = 0.5 * (1 - niveau)
    quantiles = map(stats.chi2(n * N).ppf, (marge, 1 - marge))
    return tuple(q / N for q in quantiles)


def coherence(vraies, estimees, covariances):
    tous = np.array([nees(v, e, c) for v, e, c in zip(vraies, estimees, covariances)])
    bas, haut = bande(vraies.shape[1], tous.size)
    avis = np.select([tous.mean() > haut, tous.mean() < bas], [1, -1], default=0)
    return tous.mean(), avis
