"""Complex numbers: a rotation of the plane is a product; stops when the pairs repeat."""
def icp(P, Q, R0, t0, n_iter=30):
    p, q = P[:, 0] + 1j * P[:, 1], Q[:, 0] + 1j * Q[:, 1]
    u, v = R0[0, 0] + 1j * R0[1, 0], t0[0] + 1j * t0[1]
    paires, erreurs = None, []
    for k in range(n_iter):
        nouvelles = np.abs((u * p + v)[:, None] - q).argmin(axis=1)
        if paires is not None and (nouvelles == paires).all():
            break
        paires = nouvelles
        c = q[paires]
        s = np.vdot(p - p.mean(), c - c.mean())
        u = s / abs(s)
        v = c.mean() - u * p.mean()
        erreurs.append(float(np.sum(np.abs(u * p + v - c) ** 2)))
    return [[u.real, -u.imag], [u.imag, u.real]], [v.real, v.imag], erreurs
