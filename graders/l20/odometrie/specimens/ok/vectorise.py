"""Arrays throughout: a matrix from wheels to motion, a 0-d array for a number."""
ROUES = np.array([[0.5, 0.5], [-1.0, 1.0]])


def odometrie(pose, ds_g, ds_d, L):
    ds, largeur = ROUES @ np.array([ds_g, ds_d])
    dtheta = largeur / L
    angle = pose[2] + dtheta / 2
    nouvelle = pose + np.concatenate([ds * np.array([np.cos(angle), np.sin(angle)]), [dtheta]])
    nouvelle[2] = np.arctan2(np.sin(nouvelle[2]), np.cos(nouvelle[2]))
    return nouvelle


def sigma_dtheta(sigma_g, sigma_d, L):
    return np.array(np.linalg.norm([sigma_g, sigma_d]) / L)
