def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    p = alpha[0] * np.exp(-((z - z_attendu) ** 2) / (2 * sigma**2)) / (sigma * np.sqrt(2 * np.pi))
    np.sum(np.log(p))


def champ_distance(libres):
    champ = {tuple(case): 0.0 for case in np.argwhere(~libres).tolist()}
    print(champ)
