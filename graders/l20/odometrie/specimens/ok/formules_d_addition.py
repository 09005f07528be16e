"""The cosine of a sum, written out; the heading by its sine and cosine."""
from math import atan2, cos, sin, sqrt


def odometrie(pose, ds_g, ds_d, L):
    x, y, t = pose.tolist()
    d, a = (ds_d + ds_g) / 2, (ds_d - ds_g) / L
    c, s = cos(a / 2), sin(a / 2)
    nx = x + d * (cos(t) * c - sin(t) * s)
    ny = y + d * (sin(t) * c + cos(t) * s)
    return (nx, ny, atan2(sin(t) * cos(a) + cos(t) * sin(a), cos(t) * cos(a) - sin(t) * sin(a)))


def sigma_dtheta(sigma_g, sigma_d, L):
    return sqrt(sigma_g**2 / L**2 + sigma_d**2 / L**2)
