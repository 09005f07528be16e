def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    # En divisant par le plus grand terme, puis en remettant son logarithme.
    p = np.zeros(len(z))
    p += alpha[3] / z_max
    p[z <= z_attendu] += alpha[1] * lam * np.exp(-lam * z[z <= z_attendu])
    p[z == z_max] += alpha[2]
    p += alpha[0] * (1 / np.sqrt(2 * np.pi * sigma**2)) * np.exp(-((z_attendu - z) ** 2) / (2 * sigma**2))
    return np.add.reduce(np.log(p + 1e-300))


def champ_distance(libres):
    # Felzenszwalb et Huttenlocher, sans se presser : d'abord les colonnes, puis les lignes, au carré.
    h, w = libres.shape
    grand = 10.0**9
    colonnes = np.where(libres, grand, 0.0)
    sur_y = np.array([[min((y - j) ** 2 + colonnes[j, x] for j in range(h)) for x in range(w)] for y in range(h)])
    return np.sqrt([[min((x - i) ** 2 + sur_y[y, i] for i in range(w)) for x in range(w)] for y in range(h)])
