"""A pose that knows how to be composed and to be blended."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Pose:
    x: float
    y: float
    cap: float

    def __matmul__(self, autre):
        c, s = np.cos(self.cap), np.sin(self.cap)
        return Pose(self.x + c * autre.x - s * autre.y, self.y + s * autre.x + c * autre.y, self.cap + autre.cap)

    def vers(self, autre, part):
        tour = (autre.cap - self.cap) % (2 * np.pi)
        if tour > np.pi:
            tour -= 2 * np.pi
        return Pose(
            self.x + part * (autre.x - self.x), self.y + part * (autre.y - self.y), self.cap + part * tour
        )

    def tableau(self):
        return np.array([self.x, self.y, (self.cap + np.pi) % (2 * np.pi) - np.pi])


def interpoler(a, b, part):
    return Pose(*a).vers(Pose(*b), part).tableau()


def a_la_date(dates, poses, date):
    rang = int((dates < date).sum())
    if rang == len(dates) or (rang == 0 and dates[0] != date):
        raise ValueError("date")
    if rang == 0:
        return Pose(*poses[0]).tableau()
    debut, fin = dates[rang - 1 : rang + 1]
    return interpoler(poses[rang - 1], poses[rang], (date - debut) / (fin - debut))


def chercher(messages, cible, source, date):
    total, nom = Pose(0.0, 0.0, 0.0), source
    while nom != cible:
        siens = {m[2]: m for m in messages if m[1] == nom}
        if not siens:
            raise KeyError(nom)
        if None in siens:
            lien = Pose(*siens[None][3])
        else:
            dates = np.array(sorted(siens))
            lien = Pose(*a_la_date(dates, np.array([siens[t][3] for t in dates]), date))
        total = lien @ total
        nom = next(iter(siens.values()))[0]
    return total.tableau()
