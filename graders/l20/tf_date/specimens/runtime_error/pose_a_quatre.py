def interpoler(a, b, part):
    x, y, z, theta = a
    return np.array([x, y, theta])


def a_la_date(dates, poses, date):
    return interpoler(poses[0], poses[-1], date)


def chercher(messages, cible, source, date):
    return messages[cible][source]
