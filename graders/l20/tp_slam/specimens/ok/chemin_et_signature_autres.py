# Distance et rotation comptées le long du chemin, signature triée, fermetures renvoyées dans l'autre sens, avec icp de l'élève.
import mes_fonctions as mf
from scipy.spatial import KDTree


def trajectoire(roues, L):
    poses = np.zeros((len(roues) + 1, 3))
    for k, (g, d) in enumerate(roues):
        poses[k + 1] = mf.odometrie(poses[k], g, d, L)
    return poses


def poses_cles(poses):
    gardes, chemin, tourne = [0], 0.0, 0.0
    for k in range(1, len(poses)):
        chemin += np.hypot(*(poses[k, :2] - poses[k - 1, :2]))
        tourne += abs(mf.relatif(poses[k - 1], poses[k])[2])
        if chemin >= 0.3 or tourne >= 0.4:
            gardes.append(k)
            chemin, tourne = 0.0, 0.0
    return tuple(gardes)


class Recalage:
    def __init__(self, a):
        self.a, self.arbre = a, KDTree(a)

    def place(self, pose, b):
        R = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
        return b @ R.T + pose[:2]

    def tour(self, pose, b):
        d, j = self.arbre.query(self.place(pose, b), distance_upper_bound=0.3)
        vus = np.isfinite(d)
        if vus.sum() < 3:
            return None
        R, t = mf.kabsch(b[vus], self.a[j[vus]])
        return np.array([t[0], t[1], np.arctan2(R[1, 0], R[0, 0])])

    def part(self, pose, b):
        return float((self.arbre.query(self.place(pose, b))[0] < 0.1).mean())


def recaler(points_a, points_b, depart):
    r, pose = Recalage(points_a), np.asarray(depart, dtype=float)
    for _ in range(50):
        suivante = r.tour(pose, points_b)
        if suivante is None:
            return pose, 0.0
        if np.allclose(suivante, pose, atol=1e-9):
            break
        pose = suivante
    return [pose, r.part(pose, points_b)]


def nuage(s):
    k = np.flatnonzero(s < 8.0)
    a = 2 * np.pi * k / len(s)
    return np.stack([s[k] * np.cos(a), s[k] * np.sin(a)], axis=1)


def fermetures(scans, chaine):
    tries = np.sort(scans, axis=1)
    for_all = []
    nuages = [nuage(s) for s in scans]
    for a in range(len(scans)):
        for b in range(a + 20, len(scans)):
            if np.abs(tries[a] - tries[b]).mean() > 0.25:
                continue
            d = np.asarray(mf.relatif(chaine[b], chaine[a]))
            if np.hypot(d[0], d[1]) > 1.4:
                continue
            pose, part = recaler(nuages[b], nuages[a], d)
            if part > 0.87:
                for_all.append((b, a, pose))
    return for_all


def optimiser(chaine, recalages, deplacements, boucles):
    def omega(s, t):
        return np.diag([s**-2.0, s**-2.0, t**-2.0])

    aretes = []
    for k in range(len(recalages)):
        aretes.append((k, k + 1, recalages[k], omega(0.02, 0.01)))
        aretes.append((k, k + 1, deplacements[k], omega(0.03, 0.05)))
    for a, b, z in boucles:
        aretes.append((a, b, np.array(z), omega(0.03, 0.015)))
    return mf.gauss_newton(chaine, aretes, n_iter=15)


def carte(poses, scans, forme, origine, cote, portee=8.0):
    from functools import reduce

    def ajoute(l, paire):
        p, s = paire
        return mf.integrer_scan(l, np.append((p[:2] - origine) / cote, p[2]), s / cote, portee / cote)

    return reduce(ajoute, zip(poses, scans), np.zeros(forme))
