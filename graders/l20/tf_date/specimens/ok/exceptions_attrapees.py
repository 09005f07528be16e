"""Lets Python stumble, and says what it means."""


def interpoler(a, b, part):
    tour = 2 * np.pi
    essais = [b[2] + k * tour - a[2] for k in (-1, 0, 1)]
    ecart = min(essais, key=abs)
    theta = a[2] + part * ecart
    if theta > np.pi:
        theta -= tour
    elif theta < -np.pi:
        theta += tour
    return np.array([a[0] * (1 - part) + b[0] * part, a[1] * (1 - part) + b[1] * part, theta])


def a_la_date(dates, poses, date):
    try:
        avant = max(k for k in range(len(dates)) if dates[k] <= date)
        apres = min(k for k in range(len(dates)) if dates[k] >= date)
    except ValueError:
        raise ValueError("date hors de ce qui est connu") from None
    if avant == apres:
        return np.array(poses[avant])
    return interpoler(poses[avant], poses[apres], (date - dates[avant]) / (dates[apres] - dates[avant]))


def chercher(messages, cible, source, date):
    T, repere = (0.0, 0.0, 0.0), source
    while repere != cible:
        propres = [m for m in messages if m[1] == repere]
        try:
            parent = propres[0][0]
        except IndexError:
            raise KeyError(f"{repere} n'a pas de parent") from None
        try:
            propres.sort(key=lambda m: m[2])
            lien = a_la_date([m[2] for m in propres], [m[3] for m in propres], date)
        except TypeError:
            lien = propres[0][3]
        angle = (lien[2] + T[2] + np.pi) % (2 * np.pi) - np.pi
        c, s = np.cos(lien[2]), np.sin(lien[2])
        T = (lien[0] + c * T[0] - s * T[1], lien[1] + s * T[0] + c * T[1], angle)
        repere = parent
    return T
