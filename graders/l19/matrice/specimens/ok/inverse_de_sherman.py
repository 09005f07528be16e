"""Woodbury, written from the inverse of R."""


def predire(x, P, F, Q):
    transporte = [F @ colonne for colonne in P.T]
    return F @ x, np.array([F @ ligne for ligne in np.array(transporte).T]) + Q


def corriger(x, P, z, H, R):
    W = np.linalg.inv(R)
    apres = np.linalg.inv(np.eye(len(x)) + P @ H.T @ W @ H) @ P
    return x + apres @ H.T @ W @ (z - H @ x), apres
