def ramener(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def interpoler(a, b, part):
    x = (1 - part) * a[0] + part * b[0]
    y = (1 - part) * a[1] + part * b[1]
    ecart = ramener(b[2] - a[2])
    theta = a[2] + part * ecart
    return np.array([x, y, ramener(theta)])


def a_la_date(dates, poses, date):
    if date < dates[0]:
        raise ValueError("trop tôt")
    if date > dates[-1]:
        raise ValueError("trop tard")
    k = np.searchsorted(dates, date)
    if dates[k] == date:
        return poses[k]
    part = (date - dates[k - 1]) / (dates[k] - dates[k - 1])
    return interpoler(poses[k - 1], poses[k], part)


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    x = a[0] + c * b[0] - s * b[1]
    y = a[1] + s * b[0] + c * b[1]
    return np.array([x, y, ramener(a[2] + b[2])])


def lien_a_la_date(connues, date):
    if connues[0][0] is None:
        return connues[0][1]
    rangees = sorted(connues, key=lambda connue: connue[0])
    dates = np.array([t for t, pose in rangees])
    poses = np.array([pose for t, pose in rangees])
    return a_la_date(dates, poses, date)


def chercher(messages, cible, source, date):
    parents, connues = {}, {}
    for parent, enfant, t, pose in messages:
        parents[enfant] = parent
        connues.setdefault(enfant, []).append((t, pose))
    T, repere = np.zeros(3), source
    while repere != cible:
        if repere not in parents:
            raise KeyError(repere)
        T = composer(lien_a_la_date(connues[repere], date), T)
        repere = parents[repere]
    return T
