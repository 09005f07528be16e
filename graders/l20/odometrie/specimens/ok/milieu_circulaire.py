"""The middle heading is the circular mean of both headings."""


def odometrie(pose, ds_g, ds_d, L):
    x, y, avant = pose
    apres = avant + (ds_d - ds_g) / L
    milieu = np.arctan2(np.sin(avant) + np.sin(apres), np.cos(avant) + np.cos(apres))
    ds = np.mean([ds_g, ds_d])
    return np.array([x + ds * np.cos(milieu), y + ds * np.sin(milieu), apres - 2 * np.pi * np.round(apres / (2 * np.pi))])


def sigma_dtheta(sigma_g, sigma_d, L):
    return np.hypot(sigma_g, sigma_d) / L
