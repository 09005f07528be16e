def predire(x, P, F, Q):
    return F @ x, F @ P @ F.T + Q


def corriger(x, P, z, H, R):
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S
    return x + K @ (z - H @ x), (np.eye(len(x)) - K @ H) @ P
