from scipy.ndimage import distance_transform_edt as champ


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    p = alpha[0] * np.exp(-((z - z_attendu) ** 2) / (2 * sigma**2)) / (sigma * np.sqrt(2 * np.pi))
    p += alpha[1] * lam * np.exp(-lam * z) * (z <= z_attendu) + alpha[2] * (z >= z_max) + alpha[3] / z_max
    return np.log(p).sum()
