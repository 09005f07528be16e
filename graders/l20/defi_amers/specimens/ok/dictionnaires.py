from collections import defaultdict
from itertools import chain


def systeme(poses, amers, aretes, observations):
    """H par blocs dans un dictionnaire ; les nœuds sont ('pose', i) et ('amer', j)."""
    H, b = defaultdict(lambda: 0), defaultdict(lambda: 0)
    mesures = chain(
        ((("pose", i), ("pose", j), z, w) for i, j, z, w in aretes),
        ((("pose", i), ("amer", j), z, w) for i, j, z, w in observations),
    )
    valeurs = {("pose", i): p for i, p in enumerate(poses)} | {("amer", j): a for j, a in enumerate(amers)}
    for u, v, z, w in mesures:
        e, A, B = deriver(valeurs[u], valeurs[v], z)
        H[u, u] = H[u, u] + A.T @ w @ A
        H[u, v] = H[u, v] + A.T @ w @ B
        H[v, u] = H[v, u] + B.T @ w @ A
        H[v, v] = H[v, v] + B.T @ w @ B
        b[u] = b[u] + A.T @ w @ e
        b[v] = b[v] + B.T @ w @ e
    noeuds = list(valeurs)
    vide = lambda u, v: np.zeros((len(valeurs[u]), len(valeurs[v])))
    grande = np.block([[H[u, v] if (u, v) in H else vide(u, v) for v in noeuds] for u in noeuds])
    return grande, np.concatenate([b[u] if u in b else np.zeros(len(valeurs[u])) for u in noeuds])


def deriver(p, q, z):
    R = np.array([[np.cos(p[2]), np.sin(p[2])], [-np.sin(p[2]), np.cos(p[2])]])
    vu = R @ (q[:2] - p[:2])
    A = np.array([[-R[0, 0], -R[0, 1], vu[1]], [-R[1, 0], -R[1, 1], -vu[0]]])
    if len(z) == 2:
        return vu - z, A, R
    a = (q[2] - p[2] - z[2] + np.pi) % (2 * np.pi) - np.pi
    B = np.zeros((3, 3))
    B[:2, :2], B[2, 2] = R, 1
    return np.array([*(vu - z[:2]), a]), np.vstack([A, [0, 0, -1]]), B


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    carte = poses.astype(float), amers.astype(float)
    for _ in range(n_iter):
        H, b = systeme(*carte, aretes, observations)
        facteur = np.linalg.cholesky(H[3:, 3:])
        pas = -np.linalg.solve(facteur.T, np.linalg.solve(facteur, b[3:]))
        p = carte[0].copy()
        p[1:] += pas[: p.size - 3].reshape(-1, 3)
        p[:, 2] = np.where(p[:, 2] > np.pi, p[:, 2] - 2 * np.pi, p[:, 2])
        p[:, 2] = np.where(p[:, 2] < -np.pi, p[:, 2] + 2 * np.pi, p[:, 2])
        carte = p, carte[1] + pas[p.size - 3 :].reshape(-1, 2)
    return carte
