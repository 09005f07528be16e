"""np.matrix, and its products."""


def avance(pas):
    P = np.asmatrix(pas)
    demi = P[:, 2] / 2
    d = np.multiply(P[:, 0], np.cos(demi)) + np.multiply(P[:, 1], np.sin(demi))
    return np.asarray(d).ravel()


def etalonner(pas, vrais):
    d = np.asmatrix(avance(pas)).T
    A = np.hstack([np.asmatrix(pas[:, 2]).T, d])
    u = (A.T * A).I * A.T * np.asmatrix(vrais[:, 2]).T
    g = (d.T * np.asmatrix(avance(vrais)).T) / (d.T * d)
    return g.item(), u[0, 0], u[1, 0]


def corriger(pas, gamma, beta, alpha):
    virage = beta * pas[:, 2] + alpha * avance(pas)
    lignes = []
    for p, v in zip(pas, virage):
        a = (v - p[2]) / 2
        R = np.matrix([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
        q = gamma * R * np.matrix(p[:2]).T
        lignes.append([q[0, 0], q[1, 0], v])
    return np.array(lignes)
