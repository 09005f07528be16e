"""No closed form: a minimiser over the turn, from several starts."""
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation


def matrice(v, d):
    if d == 3:
        return Rotation.from_rotvec(v).as_matrix()
    return np.array([[np.cos(v[0]), -np.sin(v[0])], [np.sin(v[0]), np.cos(v[0])]])


def kabsch(P, Q):
    d = P.shape[1]
    a, b = P - P.mean(axis=0), Q - Q.mean(axis=0)
    departs = [[0.0], [2.0]] if d == 2 else [[0, 0, 0], [-1.5, 1.5, 1]]
    essais = [least_squares(lambda v: (a @ matrice(v, d).T - b).ravel(), x0) for x0 in departs]
    R = matrice(min(essais, key=lambda e: e.cost).x, d)
    return R, Q.mean(axis=0) - R @ P.mean(axis=0)
