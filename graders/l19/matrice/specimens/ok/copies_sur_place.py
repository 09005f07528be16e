"""Copies first, then in-place work on these."""


def predire(x, P, F, Q):
    doute = P.copy()
    doute = F @ doute @ F.T
    doute += Q
    return F @ x.copy(), doute


def corriger(x, P, z, H, R):
    x, P = x.copy(), np.array(P)
    S = H @ P @ H.T
    S += R
    K = P @ H.T @ np.linalg.matrix_power(S, -1)
    x += K @ (z - H @ x)
    P -= K @ H @ P
    return x.tolist(), P.tolist()
