"""Points in the robot's frame, carried by a homogeneous matrix; everything at once with np.add.at."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    x, y, t = pose
    T = np.array([[np.cos(t), -np.sin(t), x], [np.sin(t), np.cos(t), y], [0, 0, 1]])
    n = len(scan)
    delta = np.zeros(l.shape)
    for k in range(n):
        a = 2 * np.pi * k / n
        r = np.append(np.arange(0, min(scan[k], portee_max), 0.01), scan[k] + 1e-6)
        points = T @ np.vstack([r * np.cos(a), r * np.sin(a), np.ones(len(r))])
        cases = np.floor(points[1::-1]).astype(int).T
        bonnes = np.all((cases >= 0) & (cases < l.shape), axis=1)
        touche = scan[k] < portee_max
        mur = cases[-1]
        traverse = np.unique(cases[:-1][bonnes[:-1]], axis=0)
        if touche:
            traverse = traverse[~np.all(traverse == mur, axis=1)]
        np.add.at(delta, tuple(traverse.T), -0.847)
        if touche and bonnes[-1]:
            delta[tuple(mur)] += 0.847
    return np.clip(l + delta, -5, 5)
