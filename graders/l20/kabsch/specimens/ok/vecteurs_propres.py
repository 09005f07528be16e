"""Singular vectors from the eigenvectors of H Hᵀ, each carried over by H; what H loses is completed by a QR."""


def complete(colonnes, d):
    base, _ = np.linalg.qr(np.column_stack([*colonnes, np.eye(d)]))
    return [base[:, k] for k in range(len(colonnes), d)]


def kabsch(P, Q):
    d = P.shape[1]
    H = (P - P.mean(0)).T @ (Q - Q.mean(0))
    valeurs, vecteurs = np.linalg.eigh(H @ H.T)
    gauche, droite = [], []
    for k in np.argsort(valeurs)[::-1][: d - 1]:
        u = vecteurs[:, k]
        if np.linalg.norm(H.T @ u) > 1e-7 * np.linalg.norm(H) + 1e-300:
            v = H.T @ u
            for autre in droite:
                v = v - (v @ autre) * autre
            gauche.append(u)
            droite.append(v / np.linalg.norm(v))
    gauche += complete(gauche, d)
    droite += complete(droite, d)
    U, V = np.column_stack(gauche), np.column_stack(droite)
    if np.linalg.det(U) * np.linalg.det(V) < 0:
        V[:, -1] *= -1
    R = V @ U.T
    return R, Q.mean(0) - R @ P.mean(0)
