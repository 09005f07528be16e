"""Correlated readings are made independent, then corrected one at a time, with no inverse but that of a number."""


def predire(x, P, F, Q):
    return sum(x[j] * F[:, j] for j in range(len(x))), F @ P @ F.T + Q


def corriger(x, P, z, H, R):
    variances, V = np.linalg.eigh(R)
    z, H = V.T @ z, V.T @ H
    for valeur, h, r in zip(z, H, variances):
        croisee = P @ h
        K = croisee / (h @ croisee + r)
        x = x + K * (valeur - h @ x)
        P = P - np.outer(K, croisee)
    return x, P
