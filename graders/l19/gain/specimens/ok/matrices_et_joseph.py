"""Matrices of one entry; all the readings at once are one measurement of n components."""


def gain(v, r):
    P, H, R = np.array([[v]]), np.array([[1.0]]), np.array([[r]])
    return (P @ H.T @ np.linalg.inv(H @ P @ H.T + R)).item()


def fusionner(mesures, variances):
    H = np.ones((len(mesures), 1))
    information = H.T @ np.diag(1 / variances) @ H
    P = np.linalg.inv(information)
    return (P @ H.T @ np.diag(1 / variances) @ mesures).item(), P.item()


def enchainer(m, v, mesures, variances):
    x, P, lignes = np.array([m]), np.array([[v]]), []
    for z, r in zip(mesures, variances):
        K = P / (P + r)
        x = x + K @ (z - x)
        P = (1 - K) @ P @ (1 - K).T + K * r @ K.T
        lignes.append(np.concatenate([x, P[0]]))
    return np.array(lignes)
