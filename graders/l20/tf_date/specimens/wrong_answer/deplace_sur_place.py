"""What is right, made in the arrays that were given."""


def interpoler(a, b, part):
    ecart = (b[2] - a[2] + np.pi) % (2 * np.pi) - np.pi
    a[:2] += part * (b[:2] - a[:2])
    a[2] = (a[2] + part * ecart + np.pi) % (2 * np.pi) - np.pi
    return a


def a_la_date(dates, poses, date):
    if date < dates[0] or date > dates[-1]:
        raise ValueError
    k = int(np.searchsorted(dates, date))
    if dates[k] == date:
        return poses[k]
    return interpoler(poses[k - 1], poses[k], (date - dates[k - 1]) / (dates[k] - dates[k - 1]))


def chercher(messages, cible, source, date):
    messages.sort(key=lambda m: (m[2] is not None, m[2] or 0.0))
    return np.zeros(3)
