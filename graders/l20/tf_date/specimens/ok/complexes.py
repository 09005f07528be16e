"""Poses as a complex place and a complex direction."""

import cmath


def interpoler(a, b, part):
    z, w = complex(a[0], a[1]), complex(b[0], b[1])
    ecart = cmath.phase(cmath.exp(1j * (b[2] - a[2])))
    lieu = z + part * (w - z)
    return lieu.real, lieu.imag, cmath.phase(cmath.exp(1j * (a[2] + part * ecart)))


def a_la_date(dates, poses, date):
    apres = [k for k, t in enumerate(dates) if t >= date]
    avant = [k for k, t in enumerate(dates) if t <= date]
    if not apres or not avant:
        raise ValueError("jamais vu")
    i, j = avant[-1], apres[0]
    if i == j:
        return tuple(poses[i])
    return interpoler(poses[i], poses[j], (date - dates[i]) / (dates[j] - dates[i]))


def chercher(messages, cible, source, date):
    lieu, direction, ici = 0j, 1 + 0j, source
    while ici != cible:
        miens = sorted((t, tuple(p), parent) for parent, enfant, t, p in messages if enfant == ici and t is not None)
        fixes = [(p, parent) for parent, enfant, t, p in messages if enfant == ici and t is None]
        if fixes:
            (x, y, theta), ici = fixes[0]
        elif miens:
            x, y, theta = a_la_date([m[0] for m in miens], [m[1] for m in miens], date)
            ici = miens[0][2]
        else:
            raise KeyError(ici)
        tour = cmath.exp(1j * theta)
        lieu, direction = complex(x, y) + tour * lieu, direction * tour
    return [lieu.real, lieu.imag, cmath.phase(direction)]
