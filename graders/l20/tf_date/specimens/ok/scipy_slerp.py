"""scipy's rotations: slerp takes the short way by itself."""

from scipy.spatial.transform import Rotation, Slerp


def autour_de_z(theta):
    return Rotation.from_euler("z", theta)


def interpoler(a, b, part):
    tourne = Slerp([0, 1], Rotation.concatenate([autour_de_z(a[2]), autour_de_z(b[2])]))(part)
    ou = np.array(a[:2]) + part * (np.array(b[:2]) - np.array(a[:2]))
    return np.concatenate([ou, [tourne.as_euler("zyx")[0]]])


def a_la_date(dates, poses, date):
    if date not in dates and (date < dates[0] or date > dates[-1]):
        raise ValueError("date")
    if date in dates:
        return poses[list(dates).index(date)]
    k = len([t for t in dates if t < date])
    return interpoler(poses[k - 1], poses[k], (date - dates[k - 1]) / (dates[k] - dates[k - 1]))


def chercher(messages, cible, source, date):
    point, rotation, repere = np.zeros(3), autour_de_z(0.0), source
    parents = dict((enfant, parent) for parent, enfant, _, _ in messages)
    while repere != cible:
        if parents.get(repere) is None:
            raise KeyError(repere)
        suite = {t: pose for _, enfant, t, pose in messages if enfant == repere}
        if None in suite:
            x, y, theta = suite[None]
        else:
            temps = sorted(suite)
            x, y, theta = a_la_date(np.array(temps), np.array([suite[t] for t in temps]), date)
        point = autour_de_z(theta).apply(point) + [x, y, 0]
        rotation = autour_de_z(theta) * rotation
        repere = parents[repere]
    return np.array([point[0], point[1], rotation.as_euler("zyx")[0]])
