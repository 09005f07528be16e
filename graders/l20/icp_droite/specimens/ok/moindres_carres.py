"""A square root of A gives back a least-squares problem, cut in its singular values."""
from scipy.linalg import norm


def normales(Q):
    milieu = np.vstack([Q[0], Q, Q[-1]])
    d = milieu[2:] - milieu[:-2]
    perpendiculaires = np.fliplr(d) * np.array([-1.0, 1.0])
    return perpendiculaires / norm(perpendiculaires, axis=1).reshape(-1, 1)


def systeme_droite(P, Q, N):
    a = P - np.mean(P, axis=0)
    colonnes = [N[:, 0], N[:, 1], np.linalg.det(np.stack([a, N], axis=1))]
    r = [float(np.inner(n, p - q)) for n, p, q in zip(N, P, Q)]
    A = np.array([[np.mean(u * v) for u in colonnes] for v in colonnes])
    return A, np.array([np.mean(u * np.array(r)) for u in colonnes])


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    garde = [k for k, f in enumerate(forces) if not f >= seuil]
    return np.array([axes[:, k] for k in garde]).reshape(len(garde), 3)


def pas_droite(A, g, seuil=0.01):
    grande = np.linalg.norm(A, 2)
    return np.linalg.lstsq(A, -g, rcond=seuil / grande)[0]
