"""A sparse transition matrix over all cells, made from lists of rows and columns."""
from scipy import sparse

N = H * W


def predire2d(bel, du, dv):
    Y, X = np.divmod(np.arange(N), W)
    M = sparse.csr_matrix((N, N))
    for p, dx, dy in ((0.8, du, dv), (0.1, du + dv, dv + du), (0.1, du - dv, dv - du)):
        y, x = Y + dy, X + dx
        ok = (y >= 0) & (y < H) & (x >= 0) & (x < W)
        ok[ok] = libres[y[ok], x[ok]]
        ligne = np.where(ok, y * W + x, np.arange(N))
        M = M + sparse.csr_matrix((np.full(N, p), (ligne, np.arange(N))), shape=(N, N))
    return (M @ bel.reshape(-1)).reshape(bel.shape)


def corriger2d(bel, scan_obs, sigma=0.5):
    poses = np.array([(x + 0.5, y + 0.5, 0.0) for y in range(H) for x in range(W)])
    carres = ((lidar_lot(poses, 4) - np.asarray(scan_obs)[np.newaxis]) ** 2).sum(1)
    v = sparse.diags(np.exp(-carres / (2 * sigma**2)) * libres.ravel())
    p = v @ bel.reshape(-1)
    return (p / p.sum()).reshape(H, W)
