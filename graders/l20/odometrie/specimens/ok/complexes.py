"""Complex numbers; the half turn is written -pi."""
import cmath


def odometrie(pose, ds_g, ds_d, L):
    dtheta = (ds_d - ds_g) / L
    z = complex(pose[0], pose[1]) + (ds_g + ds_d) / 2 * cmath.exp(1j * (pose[2] + dtheta / 2))
    return z.real, z.imag, cmath.phase(cmath.exp(1j * (pose[2] + dtheta)))


def sigma_dtheta(sigma_g, sigma_d, L):
    return abs(complex(sigma_g, sigma_d)) / L
