def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    A = np.empty((len(z), 4))
    A[:, 0] = np.exp(-np.square((z - z_attendu) / sigma) / 2) / sigma / np.sqrt(2 * np.pi)
    A[:, 1] = lam * np.exp(-lam * z)
    A[z > z_attendu, 1] = 0
    A[:, 2] = z >= z_max
    A[:, 3] = 1 / z_max
    return np.log(A.dot(alpha)).sum()


def champ_distance(libres):
    y, x = np.indices(libres.shape)
    c = x + 1j * y
    return np.abs(c[..., None] - c[~libres]).min(-1)
