def odometry(pose, ds_g, ds_d, L):
    return pose


def sigma_dtheta(sigma_g, sigma_d, L):
    return 0.0
