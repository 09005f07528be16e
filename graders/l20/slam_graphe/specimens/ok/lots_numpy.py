"""All edges at once, np.add.at for the sums, rows of the first pose replaced by the identity."""


def ecarts(a, b, z):
    c, s, d = np.cos(a[:, 2]), np.sin(a[:, 2]), b - a
    e = np.stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], d[:, 2]], 1) - z
    e[:, 2] = np.angle(np.exp(1j * e[:, 2]))
    return e


def erreur(xi, xj, z):
    return ecarts(xi[None], xj[None], z[None])[0]


def gauss_newton(poses, aretes, n_iter=10):
    x = poses + 0.0
    I, J = (np.array([a[k] for a in aretes]) for k in (0, 1))
    Z, O = np.stack([a[2] for a in aretes]), np.stack([a[3] for a in aretes])
    for _ in range(n_iter):
        e = ecarts(x[I], x[J], Z)
        c, s, d = np.cos(x[I, 2]), np.sin(x[I, 2]), x[J] - x[I]
        o, l = 0 * c, 0 * c + 1
        A = np.array([[-c, -s, -s * d[:, 0] + c * d[:, 1]], [s, -c, -c * d[:, 0] - s * d[:, 1]], [o, o, -l]]).transpose(2, 0, 1)
        B = np.array([[c, s, o], [-s, c, o], [o, o, l]]).transpose(2, 0, 1)
        H, b = np.zeros((len(x), len(x), 3, 3)), np.zeros_like(x)
        for P, U in ((I, A), (J, B)):
            np.add.at(b, P, np.einsum("eba,ebc,ec->ea", U, O, e))
            for Q, V in ((I, A), (J, B)):
                np.add.at(H, (P, Q), np.einsum("eba,ebc,ecd->ead", U, O, V))
        H = H.transpose(0, 2, 1, 3).reshape(x.size, x.size)
        H[:3], H[:, :3], b[0] = 0, 0, 0
        H[:3, :3] = np.eye(3)
        x -= np.linalg.solve(H, b.ravel()).reshape(x.shape)
        x[:, 2] = np.angle(np.exp(1j * x[:, 2]))
    return tuple(x)
