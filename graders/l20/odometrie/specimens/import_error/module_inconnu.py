import robotique


def odometrie(pose, ds_g, ds_d, L):
    return pose
