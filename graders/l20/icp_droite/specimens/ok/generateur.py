def voisins(Q):
    for k, q in enumerate(Q):
        yield (Q[k - 1] if k > 0 else q), (Q[k + 1] if k + 1 < len(Q) else q)


def normales(Q):
    sortie = np.empty((len(Q), 2))
    for k, ((x0, y0), (x1, y1)) in enumerate(voisins(Q)):
        sortie[k] = np.array([y0 - y1, x1 - x0]) / np.hypot(x1 - x0, y1 - y0)
    return sortie


def lignes(P, N):
    c = P.mean(axis=0)
    for (x, y), (u, v) in zip(P - c, N):
        yield u, v, v * x - u * y


def systeme_droite(P, Q, N):
    J = np.array(list(lignes(P, N)))
    r = np.vecdot(N, P - Q) if hasattr(np, "vecdot") else (N * (P - Q)).sum(1)
    return J.T @ J / len(J), r @ J / len(J)


def propres(A):
    forces, axes = np.linalg.eigh(A)
    yield from zip(forces, axes.T)


def directions_libres(A, seuil=0.01):
    return tuple(tuple(v) for f, v in propres(A) if f < seuil)


def pas_droite(A, g, seuil=0.01):
    return np.sum([-np.outer(v, v) @ g / f for f, v in propres(A) if f >= seuil], axis=0)
