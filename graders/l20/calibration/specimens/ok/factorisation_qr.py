"""By a QR factorisation; steps through homogeneous matrices."""
from scipy.linalg import solve_triangular


def matrice(x, y, theta):
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])


def avance(pas):
    # Le point d'arrivée, vu dans un repère aligné sur la corde.
    return np.array([(matrice(0, 0, -theta / 2) @ [x, y, 1])[0] for x, y, theta in pas])


def etalonner(pas, vrais):
    d = avance(pas)
    Q, R = np.linalg.qr(np.column_stack([pas[:, 2], d]))
    beta, alpha = solve_triangular(R, Q.T @ vrais[:, 2])
    q, r = np.linalg.qr(d[:, None])
    return float((q.T @ avance(vrais))[0] / r[0, 0]), float(beta), float(alpha)


def corriger(pas, gamma, beta, alpha):
    sortie = []
    for (x, y, theta), d in zip(pas, avance(pas)):
        nouveau = beta * theta + alpha * d
        x2, y2, _ = matrice(0, 0, (nouveau - theta) / 2) @ [gamma * x, gamma * y, 1]
        sortie.append((x2, y2, nouveau))
    return np.array(sortie)
