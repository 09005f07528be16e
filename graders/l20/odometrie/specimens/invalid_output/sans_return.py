def odometrie(pose, ds_g, ds_d, L):
    print(pose)


def sigma_dtheta(sigma_g, sigma_d, L):
    return "0.01 rad"
