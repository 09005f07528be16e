"""scipy.sparse, the identity added to the first block, angles wrapped with %, an early stop."""
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve


def w(t):
    return (t + np.pi) % (2 * np.pi) - np.pi


def erreur(xi, xj, z):
    R = np.array([[np.cos(xi[2]), -np.sin(xi[2])], [np.sin(xi[2]), np.cos(xi[2])]])
    return np.hstack([R.T @ (xj[:2] - xi[:2]) - z[:2], w(w(xj[2] - xi[2]) - z[2])])


def gauss_newton(poses, aretes, n_iter=10):
    x = np.asarray(poses).copy()
    avant = np.inf
    for _ in range(n_iter):
        H = sp.lil_matrix((x.size, x.size))
        b = np.zeros(x.size)
        chi2 = 0.0
        for i, j, z, om in aretes:
            c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
            d = x[j, :2] - x[i, :2]
            A = np.array([[-c, -s, -s * d[0] + c * d[1]], [s, -c, -c * d[0] - s * d[1]], [0, 0, -1]])
            B = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
            J = np.zeros((3, x.size))
            J[:, 3 * i : 3 * i + 3] = A
            J[:, 3 * j : 3 * j + 3] = B
            e = erreur(x[i], x[j], z)
            H = H + sp.csr_matrix(J.T @ om @ J)
            b += J.T @ (om @ e)
            chi2 += e @ om @ e
        H = sp.lil_matrix(H)
        H[:3, :3] = H[:3, :3] + sp.eye(3)
        x = x + spsolve(sp.csc_matrix(H), -b).reshape(-1, 3)
        x[:, 2] = w(x[:, 2])
        if abs(avant - chi2) < 1e-12 * max(chi2, 1e-6):
            break
        avant = chi2
    return x
