"""Whitened rows and np.linalg.lstsq, homogeneous matrices, a named tuple, complex step for the derivatives."""
from collections import namedtuple

Arete = namedtuple("Arete", "i j mesure info")


def angle(t):
    return t - 2 * np.pi * np.round(t / (2 * np.pi))


def brut(u, z):
    """u = (xi, xj) as six numbers, possibly complex."""
    c, s = np.cos(u[2]), np.sin(u[2])
    dx, dy = u[3] - u[0], u[4] - u[1]
    return np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], u[5] - u[2] - z[2]])


def erreur(xi, xj, z):
    e = brut(np.concatenate([xi, xj]), z)
    return [e[0], e[1], angle(e[2])]


def gauss_newton(poses, aretes, n_iter=10):
    aretes = [Arete(*a) for a in aretes]
    x = np.array(poses)
    for _ in range(n_iter):
        lignes, seconds = [], []
        for a in aretes:
            u = np.concatenate([x[a.i], x[a.j]]).astype(complex)
            D = np.stack([brut(u + 1e-30j * np.eye(6)[k], a.mesure).imag / 1e-30 for k in range(6)], axis=1)
            racine = np.linalg.cholesky(a.info).T
            ligne = np.zeros((3, x.size))
            ligne[:, 3 * a.i : 3 * a.i + 3] = D[:, :3]
            ligne[:, 3 * a.j : 3 * a.j + 3] += D[:, 3:]
            lignes.append(racine @ ligne)
            seconds.append(-racine @ erreur(x[a.i], x[a.j], a.mesure))
        pas, *_ = np.linalg.lstsq(np.vstack(lignes)[:, 3:], np.concatenate(seconds), rcond=None)
        x[1:] += pas.reshape(-1, 3)
        x[:, 2] = angle(x[:, 2])
        if np.linalg.norm(pas) < 1e-4:
            break
    return x.tolist()
