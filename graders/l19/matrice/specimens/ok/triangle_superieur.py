"""Entry by entry, half of the covariance computed and mirrored; a dictionary of the parts on the way."""
import itertools


def predire(x, P, F, Q):
    n = len(x)
    apres = np.zeros((n, n))
    for i, j in itertools.combinations_with_replacement(range(n), 2):
        apres[i, j] = apres[j, i] = F[i] @ P @ F[j] + Q[i, j]
    return np.array([F[i] @ x for i in range(n)]), apres


def corriger(x, P, z, H, R):
    etape = {"PHt": P @ H.T}
    etape["S"] = H @ etape["PHt"] + R
    etape["K"] = np.linalg.lstsq(etape["S"], etape["PHt"].T, rcond=None)[0].T
    apres = P - etape["K"] @ etape["PHt"].T
    return x + etape["K"] @ (z - H @ x), np.triu(apres) + np.triu(apres, 1).T
