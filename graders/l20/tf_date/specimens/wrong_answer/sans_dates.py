def interpoler(a, b, part):
    return a + part * (b - a)


def a_la_date(dates, poses, date):
    return [np.interp(date, dates, poses[:, k]) for k in range(3)]


def chercher(messages, cible, source, date):
    return sum(pose for parent, enfant, t, pose in messages)
