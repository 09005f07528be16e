def avance(pas):
    """La corde fait avec le cap de départ la moitié du virage : on y projette le déplacement."""
    demi = pas[:, 2] / 2
    return pas[:, 0] * np.cos(demi) + pas[:, 1] * np.sin(demi)


def etalonner(pas, vrais):
    """Deux moindres carrés : les virages, qui dépendent de deux constantes, puis les avances, d'une seule."""
    d, d_vraie = avance(pas), avance(vrais)
    A = np.column_stack([pas[:, 2], d])
    beta, alpha = np.linalg.lstsq(A, vrais[:, 2], rcond=None)[0]
    gamma = d @ d_vraie / (d @ d)
    return gamma, beta, alpha


def corriger(pas, gamma, beta, alpha):
    """Le virage change, et la corde tourne de la moitié de ce changement."""
    virage = beta * pas[:, 2] + alpha * avance(pas)
    delta = (virage - pas[:, 2]) / 2
    c, s = np.cos(delta), np.sin(delta)
    x, y = gamma * pas[:, 0], gamma * pas[:, 1]
    return np.column_stack([c * x - s * y, s * x + c * y, virage])
