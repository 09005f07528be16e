"""Homogeneous matrices, from the root down."""


def matrice(p):
    c, s = np.cos(p[2]), np.sin(p[2])
    return np.array([[c, -s, p[0]], [s, c, p[1]], [0, 0, 1]])


def lire(M):
    return np.array([M[0, 2], M[1, 2], np.arctan2(M[1, 0], M[0, 0])])


def interpoler(a, b, part):
    R = matrice(a)[:2, :2].T @ matrice(b)[:2, :2]
    angle = np.arctan2(R[1, 0], R[0, 0])
    return lire(matrice([*(a[:2] * (1 - part) + b[:2] * part), a[2] + part * angle]))


def a_la_date(dates, poses, date):
    if date > dates.max() or date < dates.min():
        raise ValueError(date)
    k = max(1, int(np.argmax(dates >= date)))
    if len(dates) == 1:
        return poses[0].copy()
    return interpoler(poses[k - 1], poses[k], (date - dates[k - 1]) / np.diff(dates)[k - 1])


def chercher(messages, cible, source, date):
    parents = {m[1]: m[0] for m in messages}
    chemin = [source]
    while chemin[-1] != cible:
        chemin.append(parents[chemin[-1]])
    M = np.eye(3)
    for enfant in chemin[-2::-1]:
        siens = [m for m in messages if m[1] == enfant]
        if siens[0][2] is None:
            M = M @ matrice(siens[0][3])
        else:
            ordre = np.argsort([m[2] for m in siens])
            t = np.array([m[2] for m in siens])[ordre]
            p = np.array([m[3] for m in siens])[ordre]
            M = M @ matrice(a_la_date(t, p, date))
    return lire(M)
