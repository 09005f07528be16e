"""A dictionary for the motion, a generator for the coordinates; much is printed."""
import math


def mouvement(g, d, L):
    return {"avance": (g + d) / 2.0, "tour": (d - g) / L}


def coordonnees(pose, m):
    cap = pose[2] + m["tour"] / 2
    yield pose[0] + m["avance"] * math.cos(cap)
    yield pose[1] + m["avance"] * math.sin(cap)
    yield math.remainder(pose[2] + m["tour"], 2 * math.pi)


def odometrie(pose, ds_g, ds_d, L):
    m = mouvement(ds_g, ds_d, L)
    print("mouvement", m)
    return list(coordonnees(pose, m))


def sigma_dtheta(sigma_g, sigma_d, L):
    return sum(s**2 for s in (sigma_g, sigma_d)) ** 0.5 / L
