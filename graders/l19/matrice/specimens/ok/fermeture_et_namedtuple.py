from collections import namedtuple

Croyance = namedtuple("Croyance", "x P")


def congruence(M):
    def transporte(C):
        return M @ C @ M.T

    return transporte


def predire(x, P, F, Q):
    return Croyance(F @ x, congruence(F)(P) + Q)


def corriger(x, P, z, H, R):
    S = congruence(H)(P) + R
    K = P @ H.T @ np.linalg.inv(S)
    print("gain", K.shape)
    return Croyance(x + K @ (z - H @ x), P - congruence(K)(S))
