def interpoler(a, b, part):
    return np.array([a[0] + part * (b[0] - a[0], 0, 0])


def a_la_date(dates, poses, date):
    return poses[0]


def chercher(messages, cible, source, date):
    return np.zeros(3)
