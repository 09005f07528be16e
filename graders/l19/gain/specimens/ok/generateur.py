def gain(v, r):
    total = v + r
    return v / total


def suite(m, v, observations):
    for z, r in observations:
        K = gain(v, r)
        innovation = z - m
        m += K * innovation
        v *= 1 - K
        yield m, v


def enchainer(m, v, mesures, variances):
    return list(suite(m, v, zip(mesures.tolist(), variances.tolist())))


def fusionner(mesures, variances):
    paires = iter(zip(mesures.tolist(), variances.tolist()))
    dernier = next(paires)
    for dernier in suite(*dernier, paires):
        pass
    return dernier
