from scipy.spatial import cKDTree
from scipy.special import logsumexp


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    with np.errstate(divide="ignore"):
        logs = np.log(alpha)[:, None] + np.vstack([
            -((z - z_attendu) ** 2) / (2 * sigma**2) - np.log(sigma) - 0.5 * np.log(2 * np.pi),
            np.where(z <= z_attendu, np.log(lam) - lam * z, -np.inf),
            np.where(z >= z_max, 0.0, -np.inf),
            np.full(len(z), -np.log(z_max)),
        ])
    return float(logsumexp(logs, axis=0).sum())


def champ_distance(libres):
    arbre = cKDTree(np.argwhere(libres == False))
    cases = np.stack(np.indices(libres.shape), axis=-1).reshape(-1, 2)
    return arbre.query(cases)[0].reshape(libres.shape)
