from math import exp, fsum, log, pi, sqrt


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    def termes(lu, prevu):
        yield alpha[0] * exp(-((lu - prevu) ** 2) / (2 * sigma**2)) / (sigma * sqrt(2 * pi))
        if lu <= prevu:
            yield alpha[1] * lam * exp(-lam * lu)
        if lu >= z_max:
            yield alpha[2]
        yield alpha[3] / z_max

    return fsum(log(fsum(termes(a, b))) for a, b in zip(z.tolist(), z_attendu.tolist()))


def champ_distance(libres):
    murs = set(zip(*np.nonzero(~libres)))
    return tuple(
        tuple(min(sqrt((y - j) ** 2 + (x - i) ** 2) for j, i in murs) for x in range(libres.shape[1]))
        for y in range(libres.shape[0])
    )
