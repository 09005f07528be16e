import cmath
import math


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    z, z_attendu, alpha = list(map(float, z)), list(map(float, z_attendu)), list(map(float, alpha))
    somme = 0.0
    k = 0
    while k < len(z):
        echo = math.exp(-((z[k] - z_attendu[k]) ** 2) / (2 * sigma * sigma)) / math.sqrt(2 * math.pi * sigma * sigma)
        imprevu = lam * math.exp(-lam * z[k]) if z[k] <= z_attendu[k] else 0.0
        portee = 1.0 if z[k] >= z_max else 0.0
        somme += math.log(alpha[0] * echo + alpha[1] * imprevu + alpha[2] * portee + alpha[3] / z_max)
        k += 1
    return somme


def champ_distance(libres):
    g = libres.tolist()
    murs = [complex(x, y) for y, l in enumerate(g) for x, libre in enumerate(l) if not libre]
    return [[min(abs(complex(x, y) - m) for m in murs) for x in range(len(g[0]))] for y in range(len(g))]
