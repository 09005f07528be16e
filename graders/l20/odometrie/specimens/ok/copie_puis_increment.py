"""A copy that is written on, index by index; the heading is updated in two halves."""


def odometrie(pose, ds_g, ds_d, L):
    p = pose.copy()
    demi = (ds_d - ds_g) / L / 2
    p[2] += demi
    p[0] += (ds_g + ds_d) / 2 * np.cos(p[2])
    p[1] += (ds_g + ds_d) / 2 * np.sin(p[2])
    p[2] += demi
    if p[2] > np.pi:
        p[2] -= 2 * np.pi
    elif p[2] <= -np.pi:
        p[2] += 2 * np.pi
    return p


def sigma_dtheta(sigma_g, sigma_d, L):
    variance = 0
    for s in (sigma_g, sigma_d):
        variance += (s / L) ** 2
    return variance ** (1 / 2)
