"""Every link of the tree becomes a function of time, then only those on the way are called."""


def ramener(a):
    a = np.fmod(a, 2 * np.pi)
    return a - 2 * np.pi * (a > np.pi) + 2 * np.pi * (a < -np.pi)


def interpoler(a, b, part):
    poids = np.array([1 - part, part])
    xy = poids @ np.array([a[:2], b[:2]])
    return np.r_[xy, ramener(a[2] + part * ramener(b[2] - a[2]))]


def a_la_date(dates, poses, date):
    avant, apres = dates <= date, dates >= date
    if not avant.any() or not apres.any():
        raise ValueError("pas de pose de ce côté")
    i, j = avant.sum() - 1, len(dates) - apres.sum()
    part = 0.0 if i == j else (date - dates[i]) / (dates[j] - dates[i])
    return interpoler(poses[i], poses[j], part)


def en_fonction_du_temps(messages):
    groupes = {}
    for parent, enfant, t, pose in messages:
        groupes.setdefault((enfant, parent), []).append((t, pose))
    fonctions = {}
    for (enfant, parent), suite in groupes.items():
        if suite[0][0] is None:
            fonctions[enfant] = parent, lambda date, pose=suite[0][1]: pose
        else:
            suite = sorted(suite, key=lambda paire: paire[0])
            temps, poses = np.array([t for t, _ in suite]), np.array([p for _, p in suite])
            fonctions[enfant] = parent, lambda date, temps=temps, poses=poses: a_la_date(temps, poses, date)
    return fonctions


def chercher(messages, cible, source, date):
    fonctions = en_fonction_du_temps(messages)
    T = np.zeros(3)
    while source != cible:
        source, lien = fonctions[source]
        p = lien(date)
        T = np.array([
            p[0] + np.cos(p[2]) * T[0] - np.sin(p[2]) * T[1],
            p[1] + np.sin(p[2]) * T[0] + np.cos(p[2]) * T[1],
            ramener(p[2] + T[2]),
        ])
    return T
