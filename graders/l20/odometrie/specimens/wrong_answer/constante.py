"""The examples of the statement, whatever is asked."""


def odometrie(pose, ds_g, ds_d, L):
    return np.array([0.9600666, 2.3980017, 1.7707963])


def sigma_dtheta(sigma_g, sigma_d, L):
    return 0.01
