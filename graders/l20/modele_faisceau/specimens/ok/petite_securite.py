def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    """Une garde contre log(0), assez petite pour ne rien changer."""
    a, b, c, d = alpha
    N = np.exp(-((z - z_attendu) ** 2) / (2 * sigma**2)) / (sigma * np.sqrt(2 * np.pi))
    p = a * N + b * lam * np.exp(-lam * z) * (z <= z_attendu).astype(int) + c * (z >= z_max) + d / z_max
    return np.sum(np.log(np.maximum(p, 1e-12)))


def champ_distance(libres):
    from scipy import ndimage

    d, (jy, jx) = ndimage.distance_transform_edt(libres.copy(), return_indices=True)
    return d.astype(np.float64)
