def predire(x, P, F, Q):
    x = F @ x
    P = F @ P @ F.T + Q


def corriger(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    x = x + K @ (z - H @ x)
    P = (np.eye(len(x)) - K @ H) @ P
