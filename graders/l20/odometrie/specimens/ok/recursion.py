"""The heading comes back by a recursive function."""
from math import cos, pi, sin, sqrt


def ramener(a):
    if a > pi:
        return ramener(a - 2 * pi)
    if a <= -pi:
        return ramener(a + 2 * pi)
    return a


def odometrie(pose, ds_g, ds_d, L):
    (x, y, t), ds, dt = pose, (ds_d + ds_g) / 2, (ds_d - ds_g) / L
    return np.array([x + ds * cos(t + dt / 2), y + ds * sin(t + dt / 2), ramener(t + dt)])


def sigma_dtheta(sigma_g, sigma_d, L):
    return sqrt((sigma_g / L) ** 2 + (sigma_d / L) ** 2)
