import math


def normales(Q):
    k = np.arange(len(Q))
    d = Q[np.minimum(k + 1, k[-1])] - Q[np.maximum(k - 1, 0)]
    caps = [math.atan2(y, x) - math.pi / 2 for x, y in d]
    return [[math.cos(t), math.sin(t)] for t in caps]


def systeme_droite(P, Q, N):
    total = np.zeros((3, 4))
    c = P.mean(axis=0)
    for k in range(len(P)):
        ax, ay = P[k] - c
        nx, ny = N[k]
        j = np.array([nx, ny, ny * ax - nx * ay])
        total += np.outer(j, np.append(j, nx * (P[k, 0] - Q[k, 0]) + ny * (P[k, 1] - Q[k, 1])))
    total /= len(P)
    return [total[:, :3], total[:, 3]]


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    nombre = int(np.count_nonzero(forces < seuil))
    return axes.T[:nombre] if nombre else []


def pas_droite(A, g, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    pas, k = np.zeros(3), 2
    while k >= 0 and forces[k] >= seuil:
        pas += -np.dot(axes[:, k], g) / forces[k] * axes[:, k]
        k -= 1
    return pas
