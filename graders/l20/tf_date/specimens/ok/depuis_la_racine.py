"""Composes from the target down, having found the way first."""


def angle_entre(a):
    return a - 2 * np.pi * np.round(a / (2 * np.pi))


def interpoler(a, b, part):
    a, b = np.asarray(a, float), np.asarray(b, float)
    d = b - a
    d[2] = angle_entre(d[2])
    p = a + part * d
    return np.array([p[0], p[1], angle_entre(p[2])])


def a_la_date(dates, poses, date):
    bas, haut = 0, len(dates) - 1
    if date < dates[bas] or date > dates[haut]:
        raise ValueError
    while haut - bas > 1:
        milieu = (bas + haut) // 2
        if dates[milieu] <= date:
            bas = milieu
        else:
            haut = milieu
    if haut == bas:
        return poses[bas]
    return interpoler(poses[bas], poses[haut], (date - dates[bas]) / (dates[haut] - dates[bas]))


def chercher(messages, cible, source, date):
    arbre = {}
    for parent, enfant, t, pose in messages:
        if enfant not in arbre:
            arbre[enfant] = {"parent": parent, "fixe": None, "dates": [], "poses": []}
        if t is None:
            arbre[enfant]["fixe"] = pose
        else:
            arbre[enfant]["dates"].append(t)
            arbre[enfant]["poses"].append(pose)
    pile = []
    repere = source
    while repere != cible:
        if repere not in arbre:
            raise KeyError(repere, "n'a pas de parent")
        pile.append(arbre[repere])
        repere = arbre[repere]["parent"]
    resultat = np.array([0.0, 0.0, 0.0])
    while pile:
        noeud = pile.pop()
        if noeud["fixe"] is not None:
            b = noeud["fixe"]
        else:
            rangs = np.argsort(noeud["dates"])
            b = a_la_date(np.array(noeud["dates"])[rangs], np.array(noeud["poses"])[rangs], date)
        c, s = np.cos(resultat[2]), np.sin(resultat[2])
        resultat = np.array([
            resultat[0] + c * b[0] - s * b[1], resultat[1] + s * b[0] + c * b[1], angle_entre(resultat[2] + b[2])
        ])
    return resultat
