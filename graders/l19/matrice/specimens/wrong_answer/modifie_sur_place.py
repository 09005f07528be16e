"""Right values, but the state and the covariance are changed in place."""


def predire(x, P, F, Q):
    x[:] = F @ x
    P[:] = F @ P @ F.T + Q
    return x, P


def corriger(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    x += K @ (z - H @ x)
    P -= K @ H @ P
    return x, P
