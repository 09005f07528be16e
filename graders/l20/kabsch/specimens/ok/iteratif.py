"""No closed form: a minimiser over the turn, from several starts."""
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation


def matrice(v, d):
    if d == 3:
        return Rotation.from_rotvec(v).as_matrix()
    return np.array([[np.cos(v[0]), -np.sin(v[0])], [np.sin(v[0]), np.cos(v[0])]])


def kabsch(P, Q):
    d = P.shape[1]
    a, b = P - P.mean(axis=0), Q - Q.mean(axis=0)
    departs = [[0.0], [2.0], [-2.0]] if d == 2 else [[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3], [-1.5, 1.5, 1]]
    # Les moindres carrés de Gauss-Newton se traînent où un nuage retourné laisse un minimum très plat : BFGS, non.
    essais = [
        minimize(lambda v: np.sum((a @ matrice(v, d).T - b) ** 2), x0, jac="3-point", options={"gtol": 1e-9})
        for x0 in departs
    ]
    R = matrice(min(essais, key=lambda e: e.fun).x, d)
    return R, Q.mean(axis=0) - R @ P.mean(axis=0)
