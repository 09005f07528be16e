"""The first pose is kept, and every later step starts from there."""
poses = []


def odometrie(pose, ds_g, ds_d, L):
    poses.append(pose)
    x, y, theta = poses[0]
    ds, dtheta = (ds_g + ds_d) / 2, (ds_d - ds_g) / L
    theta2 = np.arctan2(np.sin(theta + dtheta), np.cos(theta + dtheta))
    return [x + ds * np.cos(theta + dtheta / 2), y + ds * np.sin(theta + dtheta / 2), theta2]


def sigma_dtheta(sigma_g, sigma_d, L):
    return np.hypot(sigma_g, sigma_d) / L
