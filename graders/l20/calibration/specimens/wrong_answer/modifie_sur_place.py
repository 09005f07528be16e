"""Right numbers, but the given steps are changed."""


def avance(pas):
    pas[:, 2] /= 2
    return pas[:, 0] * np.cos(pas[:, 2]) + pas[:, 1] * np.sin(pas[:, 2])


def etalonner(pas, vrais):
    d, dv = avance(pas.copy()), avance(vrais.copy())
    vrais -= 0.0
    beta, alpha = np.linalg.lstsq(np.column_stack([pas[:, 2], d]), vrais[:, 2], rcond=None)[0]
    pas[:] = 0.0
    return np.sum(d * dv) / np.sum(d * d), beta, alpha


def corriger(pas, gamma, beta, alpha):
    virage = beta * pas[:, 2] + alpha * avance(pas.copy())
    delta = (virage - pas[:, 2]) / 2
    pas[:, :2] *= gamma
    x, y = pas[:, 0].copy(), pas[:, 1].copy()
    pas[:, 0] = x * np.cos(delta) - y * np.sin(delta)
    pas[:, 1] = x * np.sin(delta) + y * np.cos(delta)
    pas[:, 2] = virage
    return pas
