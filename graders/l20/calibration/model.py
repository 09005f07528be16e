def avance(pas):
    demi = pas[:, 2] / 2
    return pas[:, 0] * np.cos(demi) + pas[:, 1] * np.sin(demi)


def longueur(pas):
    demi = pas[:, 2] / 2
    return pas[:, 0] * np.cos(demi) + pas[:, 1] * np.sin(demi)


def etalonner(pas, vrais):
    d, d_vraie = longueur(pas), longueur(vrais)
    t, t_vrai = pas[:, 2], vrais[:, 2]
    A = np.column_stack([t, d])
    beta, alpha = np.linalg.lstsq(A, t_vrai, rcond=None)[0]
    gamma = d @ d_vraie / (d @ d)
    return gamma, beta, alpha


def corriger(pas, gamma, beta, alpha):
    d = longueur(pas)
    virage = beta * pas[:, 2] + alpha * d
    delta = (virage - pas[:, 2]) / 2
    c, s = np.cos(delta), np.sin(delta)
    x, y = gamma * pas[:, 0], gamma * pas[:, 1]
    return np.column_stack([c * x - s * y, s * x + c * y, virage])
