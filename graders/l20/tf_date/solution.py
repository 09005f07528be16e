def ramener(angle):
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def interpoler(a, b, part):
    x, y = (1.0 - part) * a[:2] + part * b[:2]
    return np.array([x, y, ramener(a[2] + part * ramener(b[2] - a[2]))])


def a_la_date(dates, poses, date):
    if not dates[0] <= date <= dates[-1]:
        raise ValueError(f"date {date} inconnue")
    k = np.searchsorted(dates, date)
    if dates[k] == date:
        return poses[k]
    part = (date - dates[k - 1]) / (dates[k] - dates[k - 1])
    return interpoler(poses[k - 1], poses[k], part)


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], ramener(a[2] + b[2])])


def chercher(messages, cible, source, date):
    T, repere = np.zeros(3), source
    while repere != cible:
        recus = [(t, parent, pose) for parent, enfant, t, pose in messages if enfant == repere]
        if not recus:
            raise KeyError(f"{source} n'est pas sous {cible}")
        if recus[0][0] is None:
            _, repere, lien = recus[0]
        else:
            recus.sort(key=lambda recu: recu[0])
            dates, parents, poses = zip(*recus, strict=True)
            lien, repere = a_la_date(np.array(dates), np.array(poses), date), parents[0]
        T = composer(lien, T)
    return T
