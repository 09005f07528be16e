"""States as columns (n, 1), made flat again at the end."""


def predire(x, P, F, Q):
    colonne = F @ x.reshape(-1, 1)
    return colonne.ravel(), F @ P @ np.transpose(F) + Q


def corriger(x, P, z, H, R):
    x, z = x[:, None], z[:, None]
    K = P @ H.T @ np.linalg.pinv(H @ P @ H.T + R)
    x = x + K @ (z - H @ x)
    P = P - K @ H @ P
    return x[:, 0], 0.5 * (P + P.T)
