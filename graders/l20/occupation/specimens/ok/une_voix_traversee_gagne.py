"""One vote a cell and a scan, where crossing wins over stopping; masks, one for each vote."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(carte, robot, mesures, zmax):
    traverse = np.zeros(carte.shape, dtype=bool)
    arrete = np.zeros(carte.shape, dtype=bool)
    n = len(mesures)
    for k in range(n):
        cap = robot[2] + k * 2 * np.pi / n
        u = np.array([np.sin(cap), np.cos(cap)])
        depart = np.array([robot[1], robot[0]])
        fin = tuple(np.floor(depart + (mesures[k] + 1e-7) * u).astype(int))
        dedans = lambda c: all(0 <= a < b for a, b in zip(c, carte.shape))
        t = np.linspace(0, min(mesures[k], zmax), 300, endpoint=False)[:, None]
        for case in set(map(tuple, np.floor(depart + t * u).astype(int).tolist())):
            if dedans(case) and not (mesures[k] < zmax and case == fin):
                traverse[case] = True
        if mesures[k] < zmax and dedans(fin):
            arrete[fin] = True
    plus = np.where(traverse, np.log(3 / 7), np.where(arrete, np.log(7 / 3), 0.0))
    return np.clip(carte + plus, -5, 5)
