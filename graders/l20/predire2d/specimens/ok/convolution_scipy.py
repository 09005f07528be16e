"""A convolution for the moves that succeed, what is left over stays; scipy and densities."""
from __future__ import annotations

from scipy.signal import convolve2d
from scipy.stats import norm


def noyau(du, dv):
    k = np.zeros((3, 3))
    k[1 + dv, 1 + du] += 0.8
    for s in (1, -1):
        k[1 + dv + s * du, 1 + du + s * dv] += 0.1
    return k


def predire2d(bel, du, dv):
    if (du, dv) == (0, 0):
        return bel
    k = noyau(du, dv)
    arrive = convolve2d(bel, k, mode="same") * libres
    reussite = convolve2d(libres.astype(float), k[::-1, ::-1], mode="same")
    return arrive + bel * (1 - reussite)


def corriger2d(bel, scan_obs, sigma=0.5):
    y, x = np.mgrid[0:H, 0:W] + 0.5
    vus = lidar_lot(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), len(scan_obs))
    v = norm.pdf(scan_obs, loc=vus, scale=sigma).prod(axis=1).reshape(H, W)
    p = v * bel * libres
    return p / (p.sum() + 1e-12)
