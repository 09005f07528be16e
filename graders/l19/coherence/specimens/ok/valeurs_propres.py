from scipy.stats import gamma


def nees(vraie, estimee, P):
    variances, axes = np.linalg.eigh(P)
    return np.sum((axes.T @ (vraie - estimee)) ** 2 / variances)


def bande(n, N, niveau=0.95):
    p = np.array([1 - niveau, 1 + niveau]) / 2
    return gamma.ppf(p, n * N / 2, scale=2 / N)


def coherence(vraies, estimees, covariances):
    variances, axes = np.linalg.eigh(covariances)
    tournees = np.matmul(np.swapaxes(axes, 1, 2), (vraies - estimees)[:, :, None])[:, :, 0]
    moyenne = (tournees**2 / variances).sum(axis=1).mean()
    return moyenne, np.searchsorted(bande(vraies.shape[1], len(vraies)), moyenne) - 1
