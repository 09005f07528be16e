"""Positions and headings as complex numbers; complex-step derivatives are not needed: they are written by hand."""
import cmath


def erreur(xi, xj, z):
    vu = (complex(*xj[:2]) - complex(*xi[:2])) * cmath.exp(-1j * xi[2]) - complex(*z[:2])
    return vu.real, vu.imag, cmath.phase(cmath.exp(1j * (xj[2] - xi[2] - z[2])))


def bloc(colonnes):
    return np.array([[c.real for c in colonnes], [c.imag for c in colonnes]])


def gauss_newton(poses, aretes, n_iter=10):
    x = np.copy(poses)
    for _ in range(n_iter):
        n = x.size
        A, g = np.zeros((n, n)), np.zeros(n)
        for i, j, z, omega in aretes:
            retour = cmath.exp(-1j * x[i, 2])
            ecart = complex(*(x[j] - x[i])[:2]) * retour
            D = np.zeros((3, n))
            D[:2, 3 * i:3 * i + 3] = bloc([-retour, -1j * retour, -1j * ecart])
            D[:2, 3 * j:3 * j + 3] = bloc([retour, 1j * retour, 0j])
            D[2, 3 * i + 2], D[2, 3 * j + 2] = -1, 1
            A += D.T @ omega @ D
            g += D.T @ omega @ erreur(x[i], x[j], z)
        pas = np.zeros(n)
        pas[3:] = np.linalg.solve(A[3:, 3:], g[3:])
        x = x - pas.reshape(-1, 3)
        x[:, 2] = np.angle(np.exp(1j * x[:, 2]))
    return x
