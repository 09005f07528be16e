from scipy.linalg import cho_factor, cho_solve


def predire(x, P, F, Q):
    racine = F @ np.linalg.cholesky(P)
    return F @ x, racine @ racine.T + Q


def corriger(x, P, z, H, R):
    B = H @ P
    facteur = cho_factor(B @ H.T + R)
    return x + B.T @ cho_solve(facteur, z - H @ x), P - B.T @ cho_solve(facteur, B)
