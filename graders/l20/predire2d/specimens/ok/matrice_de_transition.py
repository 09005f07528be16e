"""One transition matrix for each command, a linear map of the flattened belief; float32 nowhere; matrix type out."""
INDICES = {(y, x): k for k, (y, x) in enumerate(np.ndindex(H, W))}
MEMOIRE = {}


def transition(du, dv):
    if (du, dv) not in MEMOIRE:
        T = np.zeros((H * W, H * W))
        for (y, x), k in INDICES.items():
            perp = np.array([dv, du])
            for p, s in ((0.8, 0), (0.1, 1), (0.1, -1)):
                dx, dy = np.array([du, dv]) + s * perp
                arrivee = INDICES.get((y + dy, x + dx))
                if arrivee is None or not libres.flat[arrivee]:
                    arrivee = k
                T[arrivee, k] += p
        MEMOIRE[du, dv] = T
    return MEMOIRE[du, dv]


def predire2d(bel, du, dv):
    return (transition(du, dv) @ bel.ravel()).reshape(H, W)


def corriger2d(bel, scan_obs, sigma=0.5):
    v = np.zeros((H, W))
    for y in range(H):
        for x in range(W):
            v[y, x] = np.exp(-np.linalg.norm(scan_obs - lidar(np.array([x + 0.5, y + 0.5, 0.0]), 4)) ** 2 / (2 * sigma**2))
    return np.matrix(bel * v / np.sum(bel * v))
