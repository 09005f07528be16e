"""Named messages, filters, a generator of links."""

from collections import namedtuple
from math import atan2, cos, remainder, sin, tau

Message = namedtuple("Message", "parent enfant date pose")


def interpoler(a, b, part):
    reste = 1 - part
    return np.array([
        reste * a[0] + part * b[0],
        reste * a[1] + part * b[1],
        remainder(a[2] + part * remainder(b[2] - a[2], tau), tau),
    ])


def a_la_date(dates, poses, date):
    if not (min(dates) <= date <= max(dates)):
        raise ValueError(f"{date} n'est pas entre {min(dates)} et {max(dates)}")
    exactes = np.flatnonzero(dates == date)
    if exactes.size:
        return poses[exactes[0]]
    i = np.flatnonzero(dates < date)[-1]
    return interpoler(poses[i], poses[i + 1], (date - dates[i]) / (dates[i + 1] - dates[i]))


def liens(messages, cible, source):
    while source != cible:
        propres = list(filter(lambda m: m.enfant == source, messages))
        if not propres:
            raise KeyError(f"on n'atteint pas {cible}")
        yield propres
        source = propres[0].parent


def chercher(messages, cible, source, date):
    tous = [Message(*m) for m in messages]
    x, y, c, s = 0.0, 0.0, 1.0, 0.0
    for propres in liens(tous, cible, source):
        if propres[0].date is None:
            p = propres[0].pose
        else:
            propres.sort(key=lambda m: m.date)
            p = a_la_date(np.array([m.date for m in propres]), np.array([m.pose for m in propres]), date)
        cp, sp = cos(p[2]), sin(p[2])
        x, y = p[0] + cp * x - sp * y, p[1] + sp * x + cp * y
        c, s = cp * c - sp * s, sp * c + cp * s
    return x, y, atan2(s, c)
