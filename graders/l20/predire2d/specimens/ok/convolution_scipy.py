"""A convolution for the moves that succeed, what is left over stays; scipy and densities."""
from __future__ import annotations

from scipy import ndimage


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
    arrive = ndimage.convolve(bel, k, mode="constant") * libres
    reussite = ndimage.correlate(libres.astype(float), k, mode="constant", cval=0.0)
    return arrive + bel * (1 - reussite)


def densite(ecart, sigma):
    return np.exp(-0.5 * (ecart / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))


def corriger2d(bel, scan_obs, sigma=0.5):
    y, x = np.mgrid[0:H, 0:W] + 0.5
    vus = lidar_lot(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), len(scan_obs))
    v = densite(scan_obs - vus, sigma).prod(axis=1).reshape(H, W)
    p = v * bel * libres
    return p / (p.sum() + 1e-12)
