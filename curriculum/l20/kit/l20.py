"""Le monde simulé du module L20 : une carte, un robot, un lidar.

Ce fichier est la trousse que votre code trouve sans rien importer :

    np, H, W, libres, PORTEE_MAX, rng, lidar(pose, n_rayons=36, bruit=0.0), lidar_lot(poses, n_rayons)

Pour travailler chez vous, posez-le à côté de votre fichier et écrivez `from l20 import *`.

Conventions. La case (y, x) de la grille (ligne, colonne) couvre [x, x+1[ × [y, y+1[ ; les longueurs se comptent en
cases. `libres` vaut True là où le robot peut se tenir. Tout ce qui est hors de la grille est un mur. Le rayon k d'un
scan à n rayons vise l'angle theta + 2·pi·k/n. Un rayon qui ne touche rien avant la portée lit la portée elle-même.
"""

import math

import numpy as np

__all__ = ["PORTEE_MAX", "H", "W", "libres", "lidar", "lidar_lot", "np", "rng"]

PLAN = """
########################
#......#.......#.......#
#......#.......#.......#
#..............#..##...#
#......#.......#..##...#
#......#.......#.......#
###.####.......####.####
#......................#
#......................#
####.######.#####.######
#........#....#........#
#........#....#........#
#...##...#....#.....####
#...##.............#...#
#........#....#........#
########################
"""


def lire_plan(plan):
    """Lit un plan dessiné avec # (mur) et . (libre) ; renvoie un tableau de booléens (H, W)."""
    return np.array([[caractere == "." for caractere in ligne] for ligne in plan.split()])


_CARTE = lire_plan(PLAN)


class _Alea(np.random.Generator):
    """Un générateur dont `random()` et `uniform()` seuls ne renvoient jamais exactement 0."""

    def random(self, size=None, *args, **options):
        valeur = super().random(size, *args, **options)
        return valeur if size is not None or valeur > 0.0 else 2.0**-53

    def uniform(self, low=0.0, high=1.0, size=None):
        valeur = super().uniform(low, high, size)
        if size is None and np.ndim(valeur) == 0 and valeur == low and high > low:
            return low + (high - low) * 2.0**-53
        return valeur


def _distance(murs, x, y, angle, portee):
    """Distance du point (x, y) au premier mur dans la direction `angle`, de case en case (Amanatides et Woo, 1987)."""
    colonne, ligne = math.floor(x), math.floor(y)
    if murs[ligne + 1][colonne + 1]:
        return 0.0
    dx, dy = math.cos(angle), math.sin(angle)
    pas_x, pas_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    saut_x = abs(1.0 / dx) if dx else math.inf
    saut_y = abs(1.0 / dy) if dy else math.inf
    bord_x = ((colonne + (dx > 0)) - x) / dx if dx else math.inf
    bord_y = ((ligne + (dy > 0)) - y) / dy if dy else math.inf
    while True:
        if bord_x < bord_y:
            distance, colonne, bord_x = bord_x, colonne + pas_x, bord_x + saut_x
        else:
            distance, ligne, bord_y = bord_y, ligne + pas_y, bord_y + saut_y
        if distance >= portee:
            return portee
        if murs[ligne + 1][colonne + 1]:
            return distance


def _distances(murs, x, y, angle, portee):
    """Les mêmes distances pour des tableaux de rayons, tous avancés ensemble.

    La grille est lue à plat, et chaque tableau à deux lignes dit ce qu'il en est des bords en y, puis des bords en x.
    """
    dx, dy = np.cos(angle), np.sin(angle)
    vers_x, vers_y = dx > 0, dy > 0
    colonne, ligne = np.floor(x), np.floor(y)
    largeur, plat = murs.shape[1], murs.ravel()
    case = ((ligne + 1) * largeur + colonne + 1).astype(int)
    with np.errstate(divide="ignore", invalid="ignore"):
        saut = np.abs(1.0 / np.stack([dy, dx]))
        bord = np.stack([(ligne + vers_y - y) / dy, (colonne + vers_x - x) / dx])
    bord[0, dy == 0] = bord[1, dx == 0] = np.inf
    pas = np.stack([np.where(vers_y, largeur, -largeur), np.where(vers_x, 1, -1)])
    dans_un_mur = plat.take(case)
    distance = np.where(dans_un_mur, 0.0, portee)
    rayons, rangs = np.arange(len(case)), np.arange(len(case))
    restent = np.flatnonzero(~dans_un_mur)
    while restent.size:
        if restent.size < rayons.size:
            rayons, case, rangs = rayons.take(restent), case.take(restent), rangs[: restent.size]
            bord, saut, pas = (tableau.take(restent, axis=1) for tableau in (bord, saut, pas))
        prochain = np.where(bord[1] < bord[0], rangs + rangs.size, rangs)
        t = bord.take(prochain)
        case += pas.take(prochain)
        bord.put(prochain, t + saut.take(prochain))
        mur, trop_loin = plat.take(case), t >= portee
        touche = np.flatnonzero(mur & ~trop_loin)
        distance[rayons.take(touche)] = t.take(touche)
        restent = np.flatnonzero(~(mur | trop_loin))
    return distance


def _trousse(libres, portee, rng):
    """Fabrique `lidar` et `lidar_lot` pour une carte ; un mur d'une case entoure la grille."""
    hauteur, largeur = libres.shape
    murs = np.ones((hauteur + 2, largeur + 2), dtype=bool)
    murs[1:-1, 1:-1] = ~libres
    lignes = murs.tolist()

    def dans_la_carte(x, y):
        return 0 <= x < largeur and 0 <= y < hauteur

    def bruiter(scan, bruit):
        """Le bruit déplace les impacts ; un rayon qui n'a rien touché lit la portée, exactement."""
        if bruit:
            lus = np.clip(scan + rng.normal(0.0, bruit, scan.shape), 0.0, portee)
            scan = np.where(scan < portee, lus, portee)
        return scan

    def lidar(pose, n_rayons=36, bruit=0.0):
        """Scan (n_rayons,) vu depuis `pose` = (x, y, theta) ; `bruit` : écart-type des impacts, en cases."""
        x, y, theta = (float(c) for c in pose)
        if not dans_la_carte(x, y):
            return bruiter(np.zeros(n_rayons), bruit)
        angles = [theta + 2.0 * math.pi * k / n_rayons for k in range(n_rayons)]
        return bruiter(np.array([_distance(lignes, x, y, a, portee) for a in angles], dtype=float), bruit)

    def lidar_lot(poses, n_rayons):
        """Scans (m, n_rayons) sans bruit vus depuis m poses (m, 3)."""
        poses = np.asarray(poses, dtype=float).reshape(-1, 3)
        angles = poses[:, 2:3] + 2.0 * np.pi * np.arange(n_rayons) / n_rayons
        dedans = (poses[:, 0] >= 0) & (poses[:, 0] < largeur) & (poses[:, 1] >= 0) & (poses[:, 1] < hauteur)
        x, y = (np.repeat(np.where(dedans, poses[:, i], -0.5), n_rayons) for i in (0, 1))
        return _distances(murs, x, y, angles.ravel(), portee).reshape(len(poses), n_rayons)

    return lidar, lidar_lot


def configurer(libres=None, portee_max=12.0, seed=None):
    """Prépare la trousse pour une carte, une portée et une graine ; renvoie les noms que le code de l'élève trouve."""
    carte = np.array(_CARTE if libres is None else libres, dtype=bool)
    alea = _Alea(np.random.PCG64(seed))
    portee = float(portee_max)
    lidar, lidar_lot = _trousse(carte.copy(), portee, alea)
    hauteur, largeur = carte.shape
    return {
        "np": np,
        "H": hauteur,
        "W": largeur,
        "libres": carte,
        "PORTEE_MAX": portee,
        "rng": alea,
        "lidar": lidar,
        "lidar_lot": lidar_lot,
    }


globals().update(configurer())
