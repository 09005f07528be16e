def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    court = alpha[1] * lam * np.exp(-lam * z) * (z <= z_attendu)
    plein = alpha[2] * (z >= z_max)
    z -= z_attendu
    z /= sigma
    p = alpha[0] * np.exp(-0.5 * z**2) / (sigma * np.sqrt(2 * np.pi)) + court + plein + alpha[3] / z_max
    return np.sum(np.log(p))


def champ_distance(libres):
    from scipy.ndimage import distance_transform_edt

    return distance_transform_edt(libres)
