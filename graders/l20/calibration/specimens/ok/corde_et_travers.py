"""Each step in the axes of its chord: what goes ahead, what slips across; then back in those of the new chord."""


def axes_de_la_corde(pas):
    c, s = np.cos(pas[:, 2] / 2), np.sin(pas[:, 2] / 2)
    return c * pas[:, 0] + s * pas[:, 1], c * pas[:, 1] - s * pas[:, 0]


def avance(pas):
    return axes_de_la_corde(pas)[0]


def etalonner(pas, vrais):
    A = np.empty((len(pas), 2))
    A[:, 0], A[:, 1] = pas[:, 2], avance(pas)
    solution, _, rang, _ = np.linalg.lstsq(A, vrais[:, 2], rcond=None)
    assert rang == 2
    return np.linalg.lstsq(A[:, 1:], avance(vrais), rcond=None)[0].item(), *solution.tolist()


def corriger(pas, gamma, beta, alpha):
    devant, travers = axes_de_la_corde(pas)
    virage = beta * pas[:, 2] + alpha * devant
    c, s = np.cos(virage / 2), np.sin(virage / 2)
    return np.transpose([gamma * (c * devant - s * travers), gamma * (s * devant + c * travers), virage])
