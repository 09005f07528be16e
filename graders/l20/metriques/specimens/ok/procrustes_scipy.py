"""scipy's orthogonal Procrustes, mended for mirrors; rotations of scipy for the motions."""
from scipy.linalg import orthogonal_procrustes
from scipy.spatial.transform import Rotation


def ate(estimees, verite):
    A = estimees[:, :2] - estimees[:, :2].mean(axis=0)
    B = verite[:, :2] - verite[:, :2].mean(axis=0)
    R, _ = orthogonal_procrustes(A, B)
    if np.linalg.det(R) < 0:
        U, _, Vt = np.linalg.svd(A.T @ B)
        R = U @ np.diag([1, -1]) @ Vt
    return np.linalg.norm(A @ R - B) / np.sqrt(len(A))


def rpe(estimees, verite, delta):
    def mouvements(x):
        ecarts = np.column_stack([x[delta:, :2] - x[:-delta, :2], np.zeros(len(x) - delta)])
        return Rotation.from_euler("z", x[:-delta, 2:]).inv().apply(ecarts)

    return np.linalg.norm(mouvements(estimees) - mouvements(verite)) / np.sqrt(len(verite) - delta)
