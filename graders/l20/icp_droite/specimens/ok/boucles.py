"""Loops over points, and a sum direction by direction."""


def normales(Q):
    n = len(Q)
    N = np.zeros((n, 2))
    for k in range(n):
        a, b = Q[max(k - 1, 0)], Q[min(k + 1, n - 1)]
        u, v = b - a
        longueur = (u * u + v * v) ** 0.5
        N[k] = v / longueur, -u / longueur
    return N


def systeme_droite(P, Q, N):
    c = sum(P) / len(P)
    A, g = np.zeros((3, 3)), np.zeros(3)
    for p, q, m in zip(P, Q, N):
        a = p - c
        j = np.array([m[0], m[1], m[1] * a[0] - m[0] * a[1]])
        A += np.outer(j, j)
        g += j * (m @ (p - q))
    return A / len(P), g / len(P)


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    libres = []
    for k in range(3):
        if forces[k] < seuil:
            libres.append(axes[:, k])
    return libres


def pas_droite(A, g, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    pas = np.zeros(3)
    for k in range(3):
        if forces[k] > seuil:
            pas = pas - axes[:, k] * (axes[:, k] @ g) / forces[k]
    return pas
