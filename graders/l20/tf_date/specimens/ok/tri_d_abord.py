"""Sorts all messages once, then reads them in pairs."""


def tourner(v, angle):
    return np.array([v[0] * np.cos(angle) - v[1] * np.sin(angle), v[0] * np.sin(angle) + v[1] * np.cos(angle)])


def principal(angle):
    return -((np.pi - angle) % (2 * np.pi) - np.pi)


def interpoler(a, b, part):
    return np.hstack([(1 - part) * a[:2] + part * b[:2], principal(a[2] + part * principal(b[2] - a[2]))])


def a_la_date(dates, poses, date):
    assert len(dates) == len(poses)
    gauche = np.searchsorted(dates, date, side="right") - 1
    if gauche < 0:
        raise ValueError("trop tôt")
    if dates[gauche] == date:
        return poses[gauche]
    if gauche + 1 == len(dates):
        raise ValueError("trop tard")
    part = (date - dates[gauche]) / (dates[gauche + 1] - dates[gauche])
    return interpoler(poses[gauche], poses[gauche + 1], part)


def chercher(messages, cible, source, date):
    ranges = sorted(messages, key=lambda m: (m[1], m[2] is not None, 0.0 if m[2] is None else m[2]))
    index = {}
    for m in ranges:
        index.setdefault(m[1], []).append(m)
    position, angle, nom = np.zeros(2), 0.0, source
    while nom != cible:
        suite = index[nom]
        nom = suite[0][0]
        if suite[0][2] is None:
            q = suite[0][3]
        else:
            q = a_la_date(np.array([m[2] for m in suite]), np.array([m[3] for m in suite]), date)
        position = q[:2] + tourner(position, q[2])
        angle = angle + q[2]
    return np.hstack([position, principal(angle)])
