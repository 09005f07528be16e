"""Right values, but the pose that was given is written on."""


def odometrie(pose, ds_g, ds_d, L):
    dtheta = (ds_d - ds_g) / L
    pose[0] += (ds_g + ds_d) / 2 * np.cos(pose[2] + dtheta / 2)
    pose[1] += (ds_g + ds_d) / 2 * np.sin(pose[2] + dtheta / 2)
    pose[2] = np.arctan2(np.sin(pose[2] + dtheta), np.cos(pose[2] + dtheta))
    return pose


def sigma_dtheta(sigma_g, sigma_d, L):
    return np.hypot(sigma_g, sigma_d) / L
