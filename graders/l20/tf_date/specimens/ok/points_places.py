"""Carries two points of the source up to the target, and reads the pose from them."""


def cap(a, b):
    return np.arctan2(b[1] - a[1], b[0] - a[0])


def porter(pose, points):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return [(pose[0] + c * x - s * y, pose[1] + s * x + c * y) for x, y in points]


def interpoler(a, b, part):
    virage = cap((0, 0), porter((0, 0, b[2] - a[2]), [(1, 0)])[0])
    direction = porter((0, 0, a[2] + part * virage), [(1, 0)])[0]
    return np.array([*(np.array(a)[:2] + part * (np.array(b)[:2] - np.array(a)[:2])), cap((0, 0), direction)])


def a_la_date(dates, poses, date):
    if date in (dates[0], dates[-1]):
        return poses[0 if date == dates[0] else -1]
    ecarts = np.asarray(dates) - date
    if np.all(ecarts > 0) or np.all(ecarts < 0):
        raise ValueError("une seule voisine")
    j = int(np.argmax(ecarts >= 0))
    return interpoler(poses[j - 1], poses[j], ecarts[j - 1] / (ecarts[j - 1] - ecarts[j]))


def chercher(messages, cible, source, date):
    points, repere = [(0.0, 0.0), (1.0, 0.0)], source
    while repere != cible:
        fixe = [m for m in messages if m[1] == repere and m[2] is None]
        suite = sorted([m for m in messages if m[1] == repere and m[2] is not None], key=lambda m: m[2])
        if fixe:
            lien = fixe[0]
            pose = lien[3]
        elif suite:
            lien = suite[0]
            pose = a_la_date([m[2] for m in suite], [m[3] for m in suite], date)
        else:
            raise KeyError(repere)
        points, repere = porter(pose, points), lien[0]
    return np.array([*points[0], cap(*points)])
