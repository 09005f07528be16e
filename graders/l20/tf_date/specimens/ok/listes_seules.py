"""No numpy at all."""

import math

PI = math.pi


def reduit(a):
    return math.atan2(math.sin(a), math.cos(a))


def interpoler(a, b, part):
    sortie = []
    for k in range(2):
        sortie.append(float(a[k]) + part * (float(b[k]) - float(a[k])))
    sortie.append(reduit(float(a[2]) + part * reduit(float(b[2]) - float(a[2]))))
    return sortie


def a_la_date(dates, poses, date):
    trouve = None
    k = 0
    while k < len(dates):
        if dates[k] == date:
            return [float(v) for v in poses[k]]
        if k + 1 < len(dates) and dates[k] < date and date < dates[k + 1]:
            trouve = k
        k += 1
    if trouve is None:
        raise ValueError("je ne sais pas")
    duree = dates[trouve + 1] - dates[trouve]
    return interpoler(poses[trouve], poses[trouve + 1], (date - dates[trouve]) / duree)


def chercher(messages, cible, source, date):
    resultat = [0.0, 0.0, 0.0]
    courant = source
    for _ in range(len(messages) + 1):
        if courant == cible:
            return resultat
        dates, poses, parent, fixe = [], [], None, False
        for message in messages:
            if message[1] != courant:
                continue
            parent = message[0]
            if message[2] is None:
                fixe = True
                poses = [message[3]]
                break
            place = 0
            while place < len(dates) and dates[place] < message[2]:
                place += 1
            dates.insert(place, message[2])
            poses.insert(place, message[3])
        if parent is None:
            break
        lien = poses[0] if fixe else a_la_date(dates, poses, date)
        c = math.cos(lien[2])
        s = math.sin(lien[2])
        resultat = [
            lien[0] + c * resultat[0] - s * resultat[1],
            lien[1] + s * resultat[0] + c * resultat[1],
            reduit(lien[2] + resultat[2]),
        ]
        courant = parent
    raise KeyError(cible)
