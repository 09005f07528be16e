"""No inverse: a system is solved; the covariance by the form of Joseph."""


def predire(x, P, F, Q):
    return F.dot(x), F.dot(P).dot(F.T) + Q


def corriger(x, P, z, H, R):
    S = H @ P @ H.T + R
    K = np.linalg.solve(S, H @ P).T
    A = np.eye(len(x)) - K @ H
    return x + K @ (z - H @ x), A @ P @ A.T + K @ R @ K.T
