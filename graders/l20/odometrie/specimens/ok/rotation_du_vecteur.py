"""The step in the robot's frame, then turned by the first heading; colonnes and a row of shape (1, 3) laid flat."""


def odometrie(pose, ds_g, ds_d, L):
    ds, dtheta = (ds_d + ds_g) / 2, (ds_d - ds_g) / L
    local = np.array([[ds * np.cos(dtheta / 2)], [ds * np.sin(dtheta / 2)]])
    c, s = np.cos(pose[2]), np.sin(pose[2])
    monde = np.array([[c, -s], [s, c]]) @ local + pose[:2].reshape(2, 1)
    cap = np.unwrap([0.0, pose[2] + dtheta])[1]
    return np.vstack([monde, [[cap]]]).ravel()


def sigma_dtheta(sigma_g, sigma_d, L):
    return np.float64(np.sqrt(np.dot([sigma_g, sigma_d], [sigma_g, sigma_d])) / L)
