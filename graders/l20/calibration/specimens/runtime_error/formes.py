"""Each function fails on its shapes."""


def avance(pas):
    return pas[:, 3] * np.cos(pas[:, 2])


def etalonner(pas, vrais):
    A = np.column_stack([pas, avance(pas)])
    return np.linalg.solve(A, vrais)


def corriger(pas, gamma, beta, alpha):
    R = np.array([[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]])
    return pas @ R
