"""The matrix filter with matrices of one entry."""


def predire(m, v, u, q):
    F = np.eye(1)
    x, P = F @ np.array([m]) + u, F @ np.array([[v]]) @ F.T + q
    return x[0], P[0, 0]


def corriger(m, v, z, r):
    x, P, H = np.array([[m]]), np.array([[v]]), np.array([[1.0]])
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + r)
    x = x + K @ (z - H @ x)
    P = (np.eye(1) - K @ H) @ P
    return x.item(), P.item()
