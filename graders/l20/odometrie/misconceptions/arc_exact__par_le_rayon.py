def odometrie(pose, ds_g, ds_d, L):
    x, y, theta = pose
    ds, dtheta = (ds_g + ds_d) / 2, (ds_d - ds_g) / L
    if abs(dtheta) < 1e-9:
        return np.array([x + ds * np.cos(theta), y + ds * np.sin(theta), theta])
    rayon = ds / dtheta
    x = x + rayon * (np.sin(theta + dtheta) - np.sin(theta))
    y = y - rayon * (np.cos(theta + dtheta) - np.cos(theta))
    return np.array([x, y, ramener(theta + dtheta)])
