"""The matrix exponential of scipy turns the way; try and except for what never happens."""
from scipy.linalg import expm

J = np.array([[0.0, -1.0], [1.0, 0.0]])


def odometrie(pose, ds_g, ds_d, L):
    try:
        dtheta = (ds_d - ds_g) / L
    except ZeroDivisionError:
        dtheta = 0.0
    position = pose[:2] + (ds_g + ds_d) / 2 * expm((pose[2] + dtheta / 2) * J)[:, 0]
    R = expm((pose[2] + dtheta) * J)
    return np.append(position, np.arctan2(R[1, 0], R[0, 0]))


def sigma_dtheta(sigma_g, sigma_d, L):
    return float(np.sqrt(sigma_g**2 + sigma_d**2)) / float(L)
