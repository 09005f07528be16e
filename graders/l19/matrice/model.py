def predire(x, P, F, Q):
    x1 = F @ x
    P1 = F @ P @ F.T + Q
    return x1, P1


def corriger(x, P, z, H, R):
    S = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(S)
    x2 = x + K @ (z - H @ x)
    P2 = (np.eye(len(x)) - K @ H) @ P
    return x2, P2
