"""np.interp on unwrapped angles, with its ends guarded."""


def interpoler(a, b, part):
    theta = np.unwrap([a[2], b[2]])
    x, y, t = (np.interp(part, [0, 1], couple) for couple in (*np.stack([a, b], axis=1)[:2], theta))
    return np.array([x, y, np.remainder(t + np.pi, 2 * np.pi) - np.pi])


def a_la_date(dates, poses, date):
    if np.isnan(np.interp(date, dates, dates, left=np.nan, right=np.nan)):
        raise ValueError("inconnue")
    colonnes = np.unwrap(poses[:, 2])
    t = np.interp(date, dates, colonnes)
    return np.array([
        np.interp(date, dates, poses[:, 0]),
        np.interp(date, dates, poses[:, 1]),
        np.remainder(t + np.pi, 2 * np.pi) - np.pi,
    ])


def chercher(messages, cible, source, date):
    x = y = theta = 0.0
    repere = source
    while True:
        if repere == cible:
            return np.array([x, y, np.remainder(theta + np.pi, 2 * np.pi) - np.pi])
        liens = [m for m in messages if m[1] == repere]
        if len(liens) == 0:
            raise KeyError(cible)
        if liens[0][2] is None:
            a = liens[0][3]
        else:
            liens = sorted(liens, key=lambda m: m[2])
            a = a_la_date(np.array([m[2] for m in liens]), np.vstack([m[3] for m in liens]), date)
        x, y = a[0] + x * np.cos(a[2]) - y * np.sin(a[2]), a[1] + x * np.sin(a[2]) + y * np.cos(a[2])
        theta += a[2]
        repere = liens[0][0]
