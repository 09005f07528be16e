"""A class that keeps its state; scipy's align_vectors does the fit in space."""
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation


class Recalage:
    def __init__(self, P, Q, R, t):
        self.P, self.Q, self.R, self.t, self.erreurs = P, Q, np.array(R), np.array(t), []
        self.arbre = KDTree(Q)

    def pas(self):
        _, j = self.arbre.query(self.P @ self.R.T + self.t)
        B = self.Q[j]
        p, b = self.P.mean(axis=0), B.mean(axis=0)
        K = (B - b).T @ (self.P - p)
        angle = np.arctan2(K[1, 0] - K[0, 1], np.trace(K))
        self.R = Rotation.from_euler("z", angle).as_matrix()[:2, :2]
        self.t = b - self.R @ p
        self.erreurs.append(np.linalg.norm(self.P @ self.R.T + self.t - B) ** 2)


def icp(P, Q, R0, t0, n_iter=30):
    r = Recalage(P, Q, R0, t0)
    for _ in range(n_iter):
        r.pas()
    return r.R, r.t, r.erreurs
