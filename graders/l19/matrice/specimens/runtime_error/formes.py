"""Products in an order that cannot be computed, unless H is square."""


def predire(x, P, F, Q):
    return F @ x, F @ P @ F.T + Q


def corriger(x, P, z, H, R):
    S = H.T @ P @ H + R
    K = np.linalg.inv(S) @ H @ P
    return x + K @ (z - H @ x), (np.eye(len(x)) - K @ H) @ P
