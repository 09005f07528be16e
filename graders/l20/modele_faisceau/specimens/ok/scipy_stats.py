from scipy.ndimage import distance_transform_edt
from scipy.stats import expon, norm, uniform


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    causes = np.array([
        norm.pdf(z, loc=z_attendu, scale=sigma),
        np.where(z <= z_attendu, expon.pdf(z, scale=1 / lam), 0),
        (z == z_max).astype(float),
        uniform.pdf(z, 0, z_max),
    ])
    return np.log(alpha @ causes).sum()


def champ_distance(libres):
    return distance_transform_edt(libres)
