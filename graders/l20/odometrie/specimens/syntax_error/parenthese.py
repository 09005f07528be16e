def odometrie(pose, ds_g, ds_d, L):
    ds = (ds_g + ds_d / 2
    return pose


def sigma_dtheta(sigma_g, sigma_d, L):
    return sigma_g
