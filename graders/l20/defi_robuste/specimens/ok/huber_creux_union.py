import scipy.sparse as sp
from scipy.sparse.linalg import spsolve


def dimension_noyau(poses, aretes):
    """Trois par morceau : les morceaux se comptent sans calculer H."""
    parent = list(range(len(poses)))

    def racine(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for i, j, *_ in aretes:
        parent[racine(i)] = racine(j)
    return 3 * len({racine(k) for k in range(len(poses))})


def e_et_J(x, i, j, z, N):
    c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
    dx, dy = x[j, :2] - x[i, :2]
    t = x[j, 2] - x[i, 2] - z[2]
    e = np.array([c * dx + s * dy - z[0], c * dy - s * dx - z[1], np.arctan2(np.sin(t), np.cos(t))])
    lignes = np.repeat([0, 1, 2], 6)
    colonnes = np.tile([3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2], 3)
    v = [-c, -s, c * dy - s * dx, c, s, 0, s, -c, -c * dx - s * dy, -s, c, 0, 0, 0, -1, 0, 0, 1]
    return e, sp.csr_matrix((v, (lignes, colonnes)), shape=(3, N))


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    x, N = poses.copy(), poses.size
    for tour in range(n_iter + 1):
        H, b, poids = sp.csr_matrix((N, N)), np.zeros(N), []
        for i, j, z, om in aretes:
            e, J = e_et_J(x, i, j, z, N)
            w = min(1.0, delta / max(1e-9, np.sqrt(e @ om @ e)))
            poids.append(w)
            if tour < n_iter:
                H = H + J.T @ sp.csr_matrix(w * om) @ J
                b = b + J.T @ (w * om @ e)
        if tour < n_iter:
            x.ravel()[3:] += spsolve(H.tocsc()[3:, 3:], -b[3:])
            x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))
    return x, poids
