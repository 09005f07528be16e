"""The plane as complex numbers: turning is a product."""
import cmath


def vue(xi, xj):
    return complex(xj[0] - xi[0], xj[1] - xi[1]) * cmath.exp(-1j * xi[2])


def residu(xi, xj, z):
    w = vue(xi, xj) - complex(z[0], z[1])
    return (w.real, w.imag, cmath.phase(cmath.exp(1j * (xj[2] - xi[2] - z[2]))))


def colonnes(*nombres):
    return [[w.real for w, _ in nombres], [w.imag for w, _ in nombres], [a for _, a in nombres]]


def jacobiennes(xi, xj, z):
    u = cmath.exp(-1j * xi[2])
    w = vue(xi, xj)
    A = colonnes((-u, 0.0), (-1j * u, 0.0), (-1j * w, -1.0))
    B = colonnes((u, 0.0), (1j * u, 0.0), (0j, 1.0))
    return A, B


def contribution(xi, xj, z, omega):
    A, B = map(np.array, jacobiennes(xi, xj, z))
    e = np.array(residu(xi, xj, z))
    H = np.block([[A.T @ omega @ A, A.T @ omega @ B], [B.T @ omega @ A, B.T @ omega @ B]])
    return H, np.concatenate([A.T @ omega @ e, B.T @ omega @ e])
