"""Right values, but the state comes as a column (n, 1)."""


def predire(x, P, F, Q):
    return F @ x[:, None], F @ P @ F.T + Q


def corriger(x, P, z, H, R):
    x = x[:, None]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ (z[:, None] - H @ x), (np.eye(len(x)) - K @ H) @ P
