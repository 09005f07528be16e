"""The lookup first looks whether both frames are in some message, then calls itself on the parent."""

import math


def normaliser(angle):
    while angle > math.pi:
        angle -= 2 * math.pi
    while angle < -math.pi:
        angle += 2 * math.pi
    return angle


def interpoler(a, b, part):
    delta = normaliser(b[2] - a[2])
    return [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part, normaliser(a[2] + delta * part)]


def a_la_date(dates, poses, date):
    n = len(dates)
    if date == dates[n - 1]:
        return list(poses[n - 1])
    for i in range(n - 1):
        if dates[i] <= date < dates[i + 1]:
            return interpoler(poses[i], poses[i + 1], (date - dates[i]) / (dates[i + 1] - dates[i]))
    raise ValueError("hors des dates connues")


def chercher(messages, cible, source, date):
    connus = {nom for p, e, _, _ in messages for nom in (p, e)}
    if source not in connus or cible not in connus:
        raise KeyError("repère inconnu")
    if cible == source:
        return [0.0, 0.0, 0.0]
    historique = []
    parent = None
    for p, e, t, pose in messages:
        if e == source:
            parent = p
            historique.append((t, list(pose)))
    if parent is None:
        raise KeyError("repère sans parent : " + source)
    if historique[0][0] is None:
        lien = historique[0][1]
    else:
        historique.sort()
        lien = a_la_date([h[0] for h in historique], [h[1] for h in historique], date)
    x, y, theta = chercher(messages, cible, parent, date)
    return [
        x + math.cos(theta) * lien[0] - math.sin(theta) * lien[1],
        y + math.sin(theta) * lien[0] + math.cos(theta) * lien[1],
        normaliser(theta + lien[2]),
    ]
