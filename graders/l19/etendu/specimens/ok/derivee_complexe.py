"""The derivative by an imaginary step, exact to rounding."""


def distance(x, balise):
    e = x - balise
    return np.sqrt(e[0] * e[0] + e[1] * e[1])


def distance_et_jacobien(x, balise):
    pas = 1e-30
    H = [distance(x + 1j * pas * axe, balise).imag / pas for axe in np.eye(2)]
    return distance(x, balise), np.array(H)


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    S = H @ P @ H.T + r
    K = (P @ H.T) * (1 / S)
    return x + K * (z - d), P - np.matmul(K.reshape(2, 1), H.reshape(1, 2)) @ P
