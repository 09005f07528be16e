"""scipy minimises the residuals."""
from scipy.optimize import least_squares


def avance(pas):
    return pas[:, 0] * np.cos(0.5 * pas[:, 2]) + pas[:, 1] * np.sin(0.5 * pas[:, 2])


def etalonner(pas, vrais):
    d, dv = avance(pas), avance(vrais)

    def ecarts(u):
        gamma, beta, alpha = u
        return np.r_[dv - gamma * d, vrais[:, 2] - beta * pas[:, 2] - alpha * d]

    return least_squares(ecarts, [1.0, 1.0, 0.0], xtol=1e-14, ftol=1e-14, gtol=1e-14).x


def corriger(pas, gamma, beta, alpha):
    corrige = np.empty(pas.shape)
    corrige[:, 2] = beta * pas[:, 2] + alpha * avance(pas)
    demi = (corrige[:, 2] - pas[:, 2]) / 2
    corrige[:, 0] = gamma * (np.cos(demi) * pas[:, 0] - np.sin(demi) * pas[:, 1])
    corrige[:, 1] = gamma * (np.sin(demi) * pas[:, 0] + np.cos(demi) * pas[:, 1])
    return corrige
