"""The old matrix class, whose * is the product of matrices and .I the inverse."""


def predire(x, P, F, Q):
    x, P, F, Q = np.matrix(x).T, np.matrix(P), np.matrix(F), np.matrix(Q)
    return np.asarray(F * x).ravel(), np.asarray(F * P * F.T + Q)


def corriger(x, P, z, H, R):
    x, P, z, H, R = np.matrix(x).T, np.matrix(P), np.matrix(z).T, np.matrix(H), np.matrix(R)
    K = P * H.T * (H * P * H.T + R).I
    return np.asarray(x + K * (z - H * x)).ravel(), np.asarray((np.eye(len(x)) - K * H) * P)
