from collections import deque


def dimension_noyau(poses, aretes):
    voisins = {k: set() for k in range(len(poses))}
    for i, j, _, _ in aretes:
        voisins[i].add(j)
        voisins[j].add(i)
    restants, morceaux = set(voisins), 0
    while restants:
        file = deque([restants.pop()])
        morceaux += 1
        while file:
            for v in voisins[file.popleft()] & restants:
                restants.remove(v)
                file.append(v)
    return 3.0 * morceaux


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    """DCS, avec Φ = δ², sur les seules fermetures ; les positions sont des nombres complexes."""
    p, t = poses[:, 0] + 1j * poses[:, 1], poses[:, 2].copy()
    n, phi = len(p), delta**2
    s = np.ones(len(aretes))
    for _ in range(n_iter):
        H, b = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
        for k, (i, j, z, om) in enumerate(aretes):
            r = np.exp(-1j * t[i])
            vu = r * (p[j] - p[i])
            q = vu - (z[0] + 1j * z[1])
            e = np.array([q.real, q.imag, np.angle(np.exp(1j * (t[j] - t[i] - z[2])))])
            if abs(i - j) > 1:
                s[k] = min(1.0, 2 * phi / (phi + e @ om @ e))
            J = np.array([[f(v) for v in (-r, -1j * r, -1j * vu, r, 1j * r, 0)] for f in (np.real, np.imag)] + [[0, 0, -1, 0, 0, 1]])
            ou = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
            H[np.ix_(ou, ou)] += s[k] ** 2 * J.T @ om @ J
            b[ou] += s[k] ** 2 * J.T @ om @ e
        pas = np.append(np.zeros(3), np.linalg.solve(H[3:, 3:], -b[3:])).reshape(n, 3)
        p = p + pas[:, 0] + 1j * pas[:, 1]
        t = np.angle(np.exp(1j * (t + pas[:, 2])))
    return np.stack([p.real, p.imag, t], axis=1), s**2
