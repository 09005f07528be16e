"""Places as complex numbers."""


def corde(pas):
    return pas[:, 0] + 1j * pas[:, 1]


def avance(pas):
    return np.real(corde(pas) * np.exp(-0.5j * pas[:, 2]))


def etalonner(pas, vrais):
    A = np.stack([pas[:, 2], avance(pas)], axis=1)
    beta, alpha = np.linalg.pinv(A) @ vrais[:, 2]
    gamma = np.vdot(avance(pas), avance(vrais)) / np.vdot(avance(pas), avance(pas))
    return np.array([gamma, beta, alpha])


def corriger(pas, gamma, beta, alpha):
    virage = beta * pas[:, 2] + alpha * avance(pas)
    z = gamma * corde(pas) * np.exp(0.5j * (virage - pas[:, 2]))
    return np.c_[z.real, z.imag, virage]
