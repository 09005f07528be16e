"""Bounds after every ray; a while loop; the global H and W; a pose as three names; a longer step past the wall."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    resultat = np.zeros((H, W))
    resultat[:, :] = l
    n_rayons = scan.size
    k = 0
    while k < n_rayons:
        cap = pose[2] + k / n_rayons * 2 * np.pi
        pas = np.array([np.cos(cap), np.sin(cap)])
        point = pose[:2].copy()
        deja = []
        bout = pose[:2] + (scan[k] + 0.05) * pas
        mur = [int(np.floor(bout[1])), int(np.floor(bout[0]))]
        parcouru = 0
        while parcouru < scan[k] and parcouru < portee_max:
            case = [int(np.floor(point[1])), int(np.floor(point[0]))]
            if case not in deja and (case != mur or scan[k] >= portee_max):
                deja.append(case)
            point = point + 0.1 * pas
            parcouru = parcouru + 0.1
        for i, j in deja:
            if i in range(H) and j in range(W):
                resultat[i, j] -= 0.847
        if scan[k] < portee_max and mur[0] in range(H) and mur[1] in range(W):
            resultat[mur[0], mur[1]] += 0.847
        resultat = np.clip(resultat, -5, 5)
        k = k + 1
    return resultat
