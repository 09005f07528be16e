"""curve_fit of scipy for the two models."""
from scipy.optimize import curve_fit


def avance(pas):
    angle = np.multiply(pas[:, 2], 0.5)
    return np.add(np.multiply(pas[:, 0], np.cos(angle)), np.multiply(pas[:, 1], np.sin(angle)))


def modele_virage(X, beta, alpha):
    return beta * X[0] + alpha * X[1]


def etalonner(pas, vrais):
    d = avance(pas)
    (beta, alpha), _ = curve_fit(modele_virage, np.array([pas[:, 2], d]), vrais[:, 2], p0=[1, 0])
    (gamma,), _ = curve_fit(lambda x, g: g * x, d, avance(vrais), p0=[1])
    return gamma, beta, alpha


def corriger(pas, gamma, beta, alpha):
    virage = modele_virage([pas[:, 2], avance(pas)], beta, alpha)
    delta = (virage - pas[:, 2]) / 2
    x = pas[:, 0] * np.cos(delta) - pas[:, 1] * np.sin(delta)
    y = pas[:, 0] * np.sin(delta) + pas[:, 1] * np.cos(delta)
    return np.stack((gamma * x, gamma * y, virage), axis=-1)
