from collections import namedtuple

Systeme = namedtuple("Systeme", "A g")
Propre = namedtuple("Propre", "force axe")


def normales(Q):
    debut, fin = Q[1] - Q[0], Q[-1] - Q[-2]
    dedans = Q[2:] - Q[:-2]
    d = np.concatenate([debut[None], dedans, fin[None]])
    return np.dstack([d[:, 1], -d[:, 0]])[0] / np.linalg.norm(d, axis=-1, keepdims=True)


def systeme_droite(P, Q, N):
    tourne = np.array([[0.0, -1.0], [1.0, 0.0]])
    J = np.array([np.append(n, n @ tourne @ a) for n, a in zip(N, P - np.mean(P, 0))])
    return Systeme(A=J.T.dot(J) / J.shape[0], g=J.T.dot([n @ d for n, d in zip(N, P - Q)]) / J.shape[0])


def trier(A):
    forces, axes = np.linalg.eigh(A)
    return [Propre(f, axes[:, k]) for k, f in enumerate(forces)]


def directions_libres(A, seuil=0.01):
    libres = [p.axe for p in trier(A) if p.force < seuil]
    return np.vstack(libres) if libres else np.empty((0, 3))


def pas_droite(A, g, seuil=0.01):
    pas = np.zeros(3)
    for p in trier(A):
        pas -= 0 if p.force < seuil else p.axe.dot(g) * p.axe / p.force
    return pas
