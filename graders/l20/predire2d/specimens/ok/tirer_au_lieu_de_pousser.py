"""Each cell asks from where one comes to it, rather than where one goes from it."""


def libre(y, x):
    return y >= 0 and x >= 0 and y < H and x < W and libres[y][x]


def mouvements(du, dv):
    return [(0.8, du, dv), (0.1, du - dv, dv - du), (0.1, du + dv, dv + du)]


def predire2d(bel, du, dv):
    apres = [[0.0 for _ in range(W)] for _ in range(H)]
    for y in range(H):
        for x in range(W):
            if libre(y, x):
                total = 0.0
                for p, dx, dy in mouvements(du, dv):
                    if libre(y - dy, x - dx):
                        total += p * bel[y - dy][x - dx]
                    if not libre(y + dy, x + dx):
                        total += p * bel[y][x]
                apres[y][x] = total
    return np.array(apres)


def corriger2d(bel, scan_obs, sigma=0.5):
    apres = np.array([[bel[y][x] and bel[y][x] * vraisemblance(y, x, scan_obs, sigma) for x in range(W)] for y in range(H)])
    return apres / np.sum(apres)


def vraisemblance(y, x, z, s):
    return np.prod([np.exp(-((a - b) ** 2) / (2 * s * s)) for a, b in zip(z, lidar([x + 0.5, y + 0.5, 0], 4))])
