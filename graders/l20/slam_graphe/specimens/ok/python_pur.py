"""Lists and the math module only: central differences, full products, Gaussian elimination."""
import math


def ramener(t):
    while t > math.pi:
        t -= 2 * math.pi
    while t <= -math.pi:
        t += 2 * math.pi
    return t


def erreur(p, q, mesure):
    dx, dy = q[0] - p[0], q[1] - p[1]
    c, s = math.cos(p[2]), math.sin(p[2])
    return [c * dx + s * dy - mesure[0], -s * dx + c * dy - mesure[1], ramener(q[2] - p[2] - mesure[2])]


def resoudre(M, v):
    n = len(v)
    M = [ligne[:] + [v[k]] for k, ligne in enumerate(M)]
    for k in range(n):
        p = max(range(k, n), key=lambda r: abs(M[r][k]))
        M[k], M[p] = M[p], M[k]
        for r in range(k + 1, n):
            f = M[r][k] / M[k][k]
            for c in range(k, n + 1):
                M[r][c] -= f * M[k][c]
    x = [0.0] * n
    for k in reversed(range(n)):
        x[k] = (M[k][n] - sum(M[k][c] * x[c] for c in range(k + 1, n))) / M[k][k]
    return x


def gauss_newton(depart, mesures, tours=10):
    poses = [[float(v) for v in pose] for pose in depart]
    n, h = 3 * len(poses), 1e-5
    for _ in range(tours):
        H = [[0.0] * n for _ in range(n)]
        b = [0.0] * n
        for i, j, z, omega in mesures:
            e = erreur(poses[i], poses[j], z)
            colonnes = []
            for p in (i, j):
                for k in range(3):
                    garde = poses[p][k]
                    poses[p][k] = garde + h
                    plus = erreur(poses[i], poses[j], z)
                    poses[p][k] = garde - h
                    moins = erreur(poses[i], poses[j], z)
                    poses[p][k] = garde
                    colonnes.append((3 * p + k, [(plus[r] - moins[r]) / (2 * h) for r in range(3)]))
            for r, u in colonnes:
                ou = [sum(u[a] * float(omega[a][c]) for a in range(3)) for c in range(3)]
                b[r] += sum(ou[c] * e[c] for c in range(3))
                for c, v in colonnes:
                    H[r][c] += sum(ou[a] * v[a] for a in range(3))
        pas = [0.0, 0.0, 0.0] + resoudre([ligne[3:] for ligne in H[3:]], [-v for v in b[3:]])
        for k, pose in enumerate(poses):
            pose[0] += pas[3 * k]
            pose[1] += pas[3 * k + 1]
            pose[2] = ramener(pose[2] + pas[3 * k + 2])
    return poses
