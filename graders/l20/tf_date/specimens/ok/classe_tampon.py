"""A buffer as tf2 has it."""

import bisect


class Tampon:
    def __init__(self):
        self.parents = {}
        self.histoires = {}

    def ajouter(self, parent, enfant, date, pose):
        self.parents[enfant] = parent
        bisect.insort(self.histoires.setdefault(enfant, []), (-np.inf if date is None else date, tuple(pose)))

    def lien(self, enfant, date):
        histoire = self.histoires[enfant]
        if histoire[0][0] == -np.inf:
            return np.array(histoire[0][1])
        return a_la_date(np.array([h[0] for h in histoire]), np.array([h[1] for h in histoire]), date)

    def chercher(self, cible, source, date):
        pose = np.zeros(3)
        while source != cible:
            pose = composer(self.lien(source, date), pose)
            source = self.parents[source]
        return pose


def ramene(t):
    return np.arctan2(np.sin(t), np.cos(t))


def composer(a, b):
    R = np.array([[np.cos(a[2]), -np.sin(a[2])], [np.sin(a[2]), np.cos(a[2])]])
    return np.append(a[:2] + R @ b[:2], ramene(a[2] + b[2]))


def interpoler(a, b, part):
    ecart = b - a
    ecart[2] = ramene(ecart[2])
    resultat = a + part * ecart
    resultat[2] = ramene(resultat[2])
    return resultat


def a_la_date(dates, poses, date):
    droite = bisect.bisect_right(dates, date)
    gauche = bisect.bisect_left(dates, date)
    if gauche < droite:
        return poses[gauche]
    if gauche == 0 or gauche == len(dates):
        raise ValueError("extrapolation")
    t0, t1 = dates[gauche - 1], dates[gauche]
    return interpoler(poses[gauche - 1], poses[gauche], (date - t0) / (t1 - t0))


def chercher(messages, cible, source, date):
    tampon = Tampon()
    for message in messages:
        tampon.ajouter(*message)
    return tampon.chercher(cible, source, date)
