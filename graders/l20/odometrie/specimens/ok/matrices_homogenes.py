"""A product of homogeneous matrices: half the turn, the advance, the other half."""


def T(x, y, t):
    c, s = np.cos(t), np.sin(t)
    return np.array([[c, -s, x], [s, c, y], [0, 0, 1]])


def odometrie(pose, ds_g, ds_d, L):
    demi = (ds_d - ds_g) / (2 * L)
    M = T(*pose) @ T(0, 0, demi) @ T((ds_d + ds_g) / 2, 0, 0) @ T(0, 0, demi)
    return np.array([M[0, 2], M[1, 2], np.arctan2(M[1, 0], M[0, 0])])


def sigma_dtheta(sigma_g, sigma_d, L):
    J = np.array([[-1 / L, 1 / L]])
    return np.sqrt((J @ np.diag([sigma_g**2, sigma_d**2]) @ J.T).item())
