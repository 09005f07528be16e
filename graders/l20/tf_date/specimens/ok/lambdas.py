"""Lambdas and reduce."""

from functools import reduce

ramener = lambda t: (t + np.pi) % (2 * np.pi) - np.pi
composer = lambda a, b: np.array([
    a[0] + b[0] * np.cos(a[2]) - b[1] * np.sin(a[2]),
    a[1] + b[0] * np.sin(a[2]) + b[1] * np.cos(a[2]),
    ramener(a[2] + b[2]),
])
interpoler = lambda a, b, part: np.array([
    a[0] + part * (b[0] - a[0]),
    a[1] + part * (b[1] - a[1]),
    ramener(b[2] - (1 - part) * ramener(b[2] - a[2])),
])


def a_la_date(dates, poses, date):
    for (t, p), (u, q) in zip(zip(dates, poses), zip(dates[1:], poses[1:])):
        if t <= date <= u:
            return interpoler(p, q, (date - t) / (u - t))
    if len(dates) == 1 and dates[0] == date:
        return poses[0]
    raise ValueError("ni avant, ni après")


def remonter(messages, cible, source):
    au_dessus = {e: p for p, e, *_ in messages}
    noms = []
    while source != cible:
        noms.append(source)
        source = au_dessus[source]
    return noms


def chercher(messages, cible, source, date):
    def lien(nom):
        connus = sorted(((t or 0.0, k) for k, (p, e, t, q) in enumerate(messages) if e == nom))
        if messages[connus[0][1]][2] is None:
            return messages[connus[0][1]][3]
        return a_la_date([t for t, _ in connus], [messages[k][3] for _, k in connus], date)

    return reduce(lambda T, nom: composer(lien(nom), T), remonter(messages, cible, source), np.zeros(3))
