from math import cos, floor, inf, sin


def lancer_rayon(*args):
    grille, x, y, a, portee = args
    dedans = lambda i, j: 0 <= i < grille.shape[1] and 0 <= j < grille.shape[0]
    mur = lambda t: (lambda i, j: not dedans(i, j) or not grille[j, i])(floor(x + t * cos(a)), floor(y + t * sin(a)))
    bords = lambda p, d, n: [] if d == 0 else [(k - p) / d for k in range(n + 1)]
    ts = sorted(t for t in bords(x, cos(a), grille.shape[1]) + bords(y, sin(a), grille.shape[0]) if t > 0)
    return min(next((t for t in ts if mur(t + 1e-6)), inf), portee)
