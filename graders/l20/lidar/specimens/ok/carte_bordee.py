import math


def lancer_rayon(carte, px, py, alpha, portee):
    murs = np.pad(~carte, 1, constant_values=True)
    for k in range(1, 100000):
        d = k / 50
        if d > portee:
            return portee
        if murs[math.floor(py + d * math.sin(alpha)) + 1, math.floor(px + d * math.cos(alpha)) + 1]:
            return d - 0.02
