def odometrie(pose, ds_g, ds_d, L):
    return [pose[1], pose[2], pose[3]]


def sigma_dtheta(sigma_g, sigma_d, L):
    return sqrt(sigma_g**2 + sigma_d**2) / L
