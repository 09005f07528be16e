def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    theta = a[2] + b[2]
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], np.arctan2(np.sin(theta), np.cos(theta))])


def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    dx, dy, theta = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    return np.array([c * dx + s * dy, c * dy - s * dx, np.arctan2(np.sin(theta), np.cos(theta))])


def trajectoire(roues, L):
    poses = [np.zeros(3)]
    for ds_g, ds_d in roues:
        ds, dtheta = (ds_g + ds_d) / 2, (ds_d - ds_g) / L
        x, y, theta = poses[-1]
        cap = theta + dtheta / 2
        poses.append(np.array([x + ds * np.cos(cap), y + ds * np.sin(cap), theta + dtheta]))
    return np.array(poses)


def poses_cles(poses):
    gardes = [0]
    for k in range(1, len(poses)):
        x, y, theta = relatif(poses[gardes[-1]], poses[k])
        if np.hypot(x, y) >= 0.3 or abs(theta) >= 0.4:
            gardes.append(k)
    return gardes


def bouger(pose, points):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return points @ np.array([[c, s], [-s, c]]) + np.asarray(pose)[:2]


def recaler(points_a, points_b, depart):
    from mes_fonctions import kabsch
    from scipy.spatial import cKDTree

    arbre, pose = cKDTree(points_a), np.array(depart, dtype=float)
    for _ in range(30):
        bouges = bouger(pose, points_b)
        ecarts, voisins = arbre.query(bouges)
        proches = ecarts < 0.3
        if np.sum(proches) < 3:
            return pose, 0.0
        R, t = kabsch(bouges[proches], points_a[voisins[proches]])
        correction = np.array([t[0], t[1], np.arctan2(R[1, 0], R[0, 0])])
        pose = composer(correction, pose)
        if np.max(np.abs(correction)) < 1e-9:
            break
    ecarts, voisins = arbre.query(bouger(pose, points_b))
    return pose, float(np.mean(ecarts < 0.1))


def nuage(scan, portee=8.0):
    angles = 2 * np.pi * np.arange(len(scan)) / len(scan)
    return np.column_stack([scan * np.cos(angles), scan * np.sin(angles)])[scan < portee]


def fermetures(scans, chaine):
    signatures = np.abs(np.fft.rfft(scans, axis=1))[:, :8] / scans.shape[1]
    nuages = [nuage(scan) for scan in scans]
    trouvees = []
    for b in range(len(scans)):
        for a in range(b - 19):
            depart = relatif(chaine[a], chaine[b])
            if np.linalg.norm(signatures[a] - signatures[b]) < 0.15 and np.hypot(depart[0], depart[1]) < 1.5:
                pose, part = recaler(nuages[a], nuages[b], depart)
                if part > 0.85:
                    trouvees.append((a, b, pose))
    return trouvees


def information(sigma, sigma_angle):
    return np.diag([1 / sigma**2, 1 / sigma**2, 1 / sigma_angle**2])


def optimiser(chaine, recalages, deplacements, boucles):
    from mes_fonctions import gauss_newton

    aretes = [(k, k + 1, z, information(0.02, 0.01)) for k, z in enumerate(recalages)]
    aretes += [(k, k + 1, z, information(0.03, 0.05)) for k, z in enumerate(deplacements)]
    aretes += [(a, b, z, information(0.03, 0.015)) for a, b, z in boucles]
    return gauss_newton(chaine, aretes, 5)


def integrer_scan(l, pose, scan, portee):
    x, y, theta = pose
    hauteur, largeur = l.shape
    votes = np.array(l, dtype=float)
    for k, z in enumerate(scan):
        angle = theta + 2 * np.pi * k / len(scan)
        d = np.append(np.arange(0, min(z, portee), 0.05), z + 1e-6)
        i, j = np.floor(y + d * np.sin(angle)).astype(int), np.floor(x + d * np.cos(angle)).astype(int)
        dedans = (i >= 0) & (i < hauteur) & (j >= 0) & (j < largeur)
        cases = np.where(dedans, i * largeur + j, -1)
        arret = cases[-1] if z < portee else -1
        traversees = np.unique(cases[:-1])
        votes.flat[traversees[(traversees >= 0) & (traversees != arret)]] -= np.log(0.7 / 0.3)
        if arret >= 0:
            votes.flat[arret] += np.log(0.7 / 0.3)
    return np.clip(votes, -5, 5)


def carte(poses, scans, forme, origine, cote, portee=8.0):
    l = np.zeros(forme)
    for pose, scan in zip(poses, scans, strict=True):
        en_cases = np.array([(pose[0] - origine[0]) / cote, (pose[1] - origine[1]) / cote, pose[2]])
        l = integrer_scan(l, en_cases, scan / cote, portee / cote)
    return l
