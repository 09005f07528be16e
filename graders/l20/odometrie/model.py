def ramener(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)


def odometrie(pose, ds_g, ds_d, L):
    x, y, theta = pose
    ds = (ds_d + ds_g) / 2
    dtheta = (ds_d - ds_g) / L
    cap = theta + dtheta / 2
    x1 = x + ds * np.cos(cap)
    y1 = y + ds * np.sin(cap)
    return np.array([x1, y1, ramener(theta + dtheta)])


def sigma_dtheta(sigma_g, sigma_d, L):
    return np.sqrt(sigma_g**2 + sigma_d**2) / L
