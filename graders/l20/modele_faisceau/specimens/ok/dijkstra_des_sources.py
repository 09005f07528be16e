import heapq


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    def log_p(lu, prevu):
        e = (lu - prevu) / sigma
        termes = [alpha[0] / sigma / (2 * np.pi) ** 0.5 * np.e ** (-e * e / 2), alpha[3] / z_max]
        termes += [alpha[1] * lam * np.e ** (-lam * lu)] * bool(lu <= prevu)
        termes += [alpha[2]] * bool(lu >= z_max)
        return np.log(np.sum(termes))

    return np.sum(np.frompyfunc(log_p, 2, 1)(z, z_attendu).astype(float))


def champ_distance(libres):
    # Chaque mur pose sa distance partout ; le tas sert les plus petites d'abord.
    h, w = libres.shape
    tas = [((y - j) ** 2 + (x - i) ** 2, y, x) for j, i in np.argwhere(~libres) for y in range(h) for x in range(w)]
    heapq.heapify(tas)
    champ = {}
    while len(champ) < h * w:
        d, y, x = heapq.heappop(tas)
        champ.setdefault((y, x), d)
    return np.sqrt(np.array([[champ[y, x] for x in range(w)] for y in range(h)], dtype=float))
