"""The residuals handed to scipy.optimize.least_squares; 0-d arrays for the angle."""
from scipy.optimize import least_squares


def erreur(xi, xj, z):
    u = (xj[0] - xi[0] + 1j * (xj[1] - xi[1])) * np.exp(-1j * xi[2])
    return [u.real - z[0], u.imag - z[1], np.array(np.angle(np.exp(1j * (xj[2] - xi[2] - z[2]))))]


def gauss_newton(poses, aretes, n_iter=10):
    def f(v):
        x = np.vstack([poses[:1], v.reshape(-1, 3)])
        return np.concatenate([np.sqrt(om) @ erreur(x[i], x[j], z) for i, j, z, om in aretes])

    s = least_squares(f, poses[1:].ravel(), method="lm", xtol=1e-13, ftol=1e-13, gtol=1e-13)
    x = np.vstack([poses[:1], s.x.reshape(-1, 3)])
    x[:, 2] = np.angle(np.exp(1j * x[:, 2]))
    return x
