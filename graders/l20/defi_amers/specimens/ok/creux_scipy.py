import scipy.sparse as sp
from scipy.sparse.linalg import spsolve


def tourne(theta):
    return np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])


def tourne_prime(theta):
    return np.array([[-np.sin(theta), np.cos(theta)], [-np.cos(theta), -np.sin(theta)]])


def systeme(poses, amers, aretes, observations):
    n, m = len(poses), len(amers)
    lignes, colonnes, valeurs = [], [], []
    b = np.zeros(3 * n + 2 * m)

    def pose_blocs(indices, J, omega, e):
        M = J.T @ omega @ J
        b[indices] += J.T @ omega @ e
        for r, i in enumerate(indices):
            for c, j in enumerate(indices):
                lignes.append(i)
                colonnes.append(j)
                valeurs.append(M[r, c])

    for i, j, z, omega in aretes:
        d = poses[j, :2] - poses[i, :2]
        Rt = tourne(poses[i, 2])
        a = poses[j, 2] - poses[i, 2] - z[2]
        e = np.append(Rt @ d - z[:2], np.angle(np.exp(1j * a)))
        J = np.zeros((3, 6))
        J[:2, :2], J[:2, 2], J[2, 2] = -Rt, tourne_prime(poses[i, 2]) @ d, -1
        J[:2, 3:5], J[2, 5] = Rt, 1
        pose_blocs([3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2], J, omega, e)
    for i, j, z, omega in observations:
        d = amers[j] - poses[i, :2]
        Rt = tourne(poses[i, 2])
        J = np.hstack([-Rt, (tourne_prime(poses[i, 2]) @ d)[:, None], Rt])
        k = 3 * n + 2 * j
        pose_blocs([3 * i, 3 * i + 1, 3 * i + 2, k, k + 1], J, omega, Rt @ d - z)
    H = sp.coo_matrix((valeurs, (lignes, colonnes)), shape=(len(b), len(b))).tocsc()
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    poses, amers = np.copy(poses), np.copy(amers)
    for _ in range(n_iter):
        H, b = systeme(poses, amers, aretes, observations)
        pas = spsolve(H[3:, 3:], -b[3:])
        pas = np.concatenate([[0, 0, 0], pas])
        poses += pas[: poses.size].reshape(poses.shape)
        amers += pas[poses.size :].reshape(amers.shape)
        poses[:, 2] = np.pi - np.mod(np.pi - poses[:, 2], 2 * np.pi)
    return poses, amers
