"""The propagation by finite differences of a linear function, which are exact."""


def dtheta(ds_g, ds_d, L):
    return (ds_d - ds_g) / L


def odometrie(pose, ds_g, ds_d, L):
    ds, dt = 0.5 * ds_d + 0.5 * ds_g, dtheta(ds_g, ds_d, L)
    x, y, t = pose
    return np.stack([x + ds * np.cos(t + 0.5 * dt), y + ds * np.sin(t + 0.5 * dt), np.pi - np.mod(np.pi - (t + dt), 2 * np.pi)])


def sigma_dtheta(sigma_g, sigma_d, L):
    par_g = (dtheta(1.0, 0.0, L) - dtheta(-1.0, 0.0, L)) / 2
    par_d = (dtheta(0.0, 1.0, L) - dtheta(0.0, -1.0, L)) / 2
    return np.sqrt((par_g * sigma_g) ** 2 + (par_d * sigma_d) ** 2)
