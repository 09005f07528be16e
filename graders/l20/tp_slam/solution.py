from mes_fonctions import composer, gauss_newton, integrer_scan, kabsch, odometrie, relatif
from scipy.spatial import cKDTree


def trajectoire(roues, L):
    """Les n poses (n, 3) que comptent les roues (n - 1, 2), depuis la pose nulle."""
    poses = [np.zeros(3)]
    for ds_g, ds_d in roues:
        poses.append(np.asarray(odometrie(poses[-1], ds_g, ds_d, L)))
    return np.array(poses)


def poses_cles(poses, distance=0.3, angle=0.4):
    """Les indices gardés : le premier, puis chaque fois qu'on s'est éloigné, ou tourné, depuis le dernier gardé."""
    gardes = [0]
    for k in range(1, len(poses)):
        # Vu de la dernière pose clé : son angle est déjà ramené dans ]-pi, pi].
        x, y, theta = relatif(poses[gardes[-1]], poses[k])
        if np.hypot(x, y) >= distance or abs(theta) >= angle:
            gardes.append(k)
    return gardes


def bouger(pose, points):
    """Les points (m, 2) exprimés dans le repère où se lit la pose."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return points @ np.array([[c, s], [-s, c]]) + np.asarray(pose)[:2]


def recaler(points_a, points_b, depart):
    """La pose de b vue de a, et la part des points de b qui y trouvent un voisin à moins de 10 cm."""
    arbre, pose = cKDTree(points_a), np.array(depart, dtype=float)
    for _ in range(30):
        bouges = bouger(pose, points_b)
        ecarts, voisins = arbre.query(bouges)
        proches = ecarts < 0.3
        if np.sum(proches) < 3:
            return pose, 0.0
        R, t = kabsch(bouges[proches], points_a[voisins[proches]])
        # La correction s'applique à des points déjà placés dans a : elle se compose à gauche.
        correction = np.array([t[0], t[1], np.arctan2(R[1, 0], R[0, 0])])
        pose = np.asarray(composer(correction, pose))
        if np.max(np.abs(correction)) < 1e-9:
            break  # les voisins sont restés les mêmes : les tours suivants ne changeraient plus rien
    ecarts, _ = arbre.query(bouger(pose, points_b))
    return pose, float(np.mean(ecarts < 0.1))


def nuage(scan, portee=8.0):
    """Les points vus, dans le repère du robot ; un rayon qui lit la portée n'a rien vu."""
    angles = 2 * np.pi * np.arange(len(scan)) / len(scan)
    return np.column_stack([scan * np.cos(angles), scan * np.sin(angles)])[scan < portee]


def fermetures(scans, chaine):
    """Les boucles (a, b, pose de b vue de a) qu'un recalage confirme."""
    signatures = np.abs(np.fft.rfft(scans, axis=1))[:, :8] / scans.shape[1]
    nuages = [nuage(scan) for scan in scans]
    trouvees = []
    for b in range(len(scans)):
        for a in range(b - 19):
            if np.linalg.norm(signatures[a] - signatures[b]) >= 0.15:
                continue
            depart = relatif(chaine[a], chaine[b])
            if np.hypot(depart[0], depart[1]) >= 1.5:
                continue
            pose, part = recaler(nuages[a], nuages[b], depart)
            if part > 0.85:
                trouvees.append((a, b, pose))
    return trouvees


def information(sigma, sigma_angle):
    return np.diag([1 / sigma**2, 1 / sigma**2, 1 / sigma_angle**2])


def optimiser(chaine, recalages, deplacements, boucles):
    """Les poses qui accordent au mieux les recalages, l'odométrie et les boucles."""
    aretes = [(k, k + 1, z, information(0.02, 0.01)) for k, z in enumerate(recalages)]
    aretes += [(k, k + 1, z, information(0.03, 0.05)) for k, z in enumerate(deplacements)]
    aretes += [(a, b, z, information(0.03, 0.015)) for a, b, z in boucles]
    return gauss_newton(chaine, aretes, 10)


def carte(poses, scans, forme, origine, cote, portee=8.0):
    """Les log-odds (H, W) d'une grille dont la case (0, 0) a son coin en `origine` ; `cote` en mètres."""
    l = np.zeros(forme)
    for pose, scan in zip(poses, scans, strict=True):
        # integrer_scan compte en cases : on change de repère, puis d'unité.
        en_cases = np.array([(pose[0] - origine[0]) / cote, (pose[1] - origine[1]) / cote, pose[2]])
        l = np.asarray(integrer_scan(l, en_cases, scan / cote, portee / cote))
    return l
