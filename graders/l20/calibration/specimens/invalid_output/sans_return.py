def avance(pas):
    d = pas[:, 0] * np.cos(pas[:, 2] / 2) + pas[:, 1] * np.sin(pas[:, 2] / 2)


def etalonner(pas, vrais):
    print(pas.shape)


def corriger(pas, gamma, beta, alpha):
    virage = beta * pas[:, 2]
