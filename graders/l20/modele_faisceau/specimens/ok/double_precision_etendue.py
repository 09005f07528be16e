def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    z, m = np.asarray(z, dtype=np.longdouble), np.asarray(z_attendu, dtype=np.longdouble)
    p = alpha[0] * np.exp(-((z - m) ** 2) / (2 * sigma**2)) / (sigma * np.sqrt(2 * np.pi))
    p = p + alpha[1] * (z <= m) * lam * np.exp(-lam * z) + alpha[2] * (z >= z_max) + alpha[3] / z_max
    return float(np.sum(np.log(p)))


def champ_distance(libres):
    d = np.zeros(libres.shape)
    for (y, x), libre in np.ndenumerate(libres):
        r = 0
        while libre:
            # Des carrés de plus en plus grands ; un mur trouvé à d peut être battu jusqu'au carré de côté d.
            r += 1
            bloc = np.argwhere(~libres[max(0, y - r):y + r + 1, max(0, x - r):x + r + 1])
            if len(bloc):
                bloc = bloc + [max(0, y - r), max(0, x - r)]
                d[y, x] = np.min(np.hypot(*(bloc - [y, x]).T))
                if d[y, x] <= r:
                    break
    return d
