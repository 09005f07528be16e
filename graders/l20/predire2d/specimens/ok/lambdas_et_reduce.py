from functools import reduce

dedans = lambda y, x: 0 <= y < H and 0 <= x < W and bool(libres[y, x])
ou = lambda y, x, dy, dx: (y + dy, x + dx) if dedans(y + dy, x + dx) else (y, x)
issues = lambda du, dv: [(0.8, dv, du), (0.1, dv + du, du + dv), (0.1, dv - du, du - dv)]
cases = lambda b: [(y, x) for y in range(H) for x in range(W) if b[y, x]]
un = lambda c, v: np.where((np.arange(H)[:, None] == c[0]) & (np.arange(W) == c[1]), v, 0.0)
predire2d = lambda b, du, dv: reduce(
    np.add, (un(ou(y, x, dy, dx), p * b[y, x]) for y, x in cases(b) for p, dy, dx in issues(du, dv)))
brute = lambda b, z, s: reduce(np.add, (
    un(c, b[c] * np.exp(-np.sum((z - lidar((c[1] + 0.5, c[0] + 0.5, 0.0), 4)) ** 2) / (2 * s**2))) for c in cases(b)))
un_a_la_somme = lambda t: t / t.sum()
corriger2d = lambda b, z, s=0.5: un_a_la_somme(brute(b, z, s))
