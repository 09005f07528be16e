"""Real scans of the practical work, as they are downloaded: a log of the Intel laboratory, and its beginning apart.

`files()` gives what is downloaded, by name.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.tp_slam.journeys import LOG, indoor
from reference.formats.trajectory_files import Trajectory, write_tum
from reference.se2 import relative

READ_ME = """Des scans du laboratoire d'Intel, à Seattle (TP « SLAM et navigation », partie A bis)

Enregistrés par Dirk Hähnel sur un vrai robot ; jeu de données du banc d'essai SLAM de Fribourg.
Unités : mètres, radians. Le TP se fait sur les 120 premiers scans ; le dossier tout/ contient les 910 du journal.

scans.csv        un scan par ligne, 180 distances ; le rayon k vise l'angle -pi/2 + pi*k/180 depuis le cap
                 une lecture de 20 m ou plus ne voit rien
odometrie.csv    x, y, theta : l'odométrie du robot à chaque scan, depuis la pose nulle, telle qu'il l'a comptée
boucles.csv      a, b, x, y, theta : deux scans où notre reconnaissance de lieux croit voir les mêmes murs, et une
                 idée grossière de la pose de b vue de a. Elle se trompe parfois.
reference.tum    t x y z qx qy qz qw : les poses que le journal donne, trouvées par un SLAM à grille ; t est un rang
                 pour mesurer vos erreurs à la fin seulement
tout/scans.csv, tout/odometrie.csv, tout/reference.tum
                 les mêmes, pour le journal entier : à regarder
"""


def files() -> dict[str, bytes]:
    """Name to content."""
    place = indoor()
    with np.load(LOG) as log:
        scans, odometry, poses = log["centimetres"] / 100.0, log["odometry"], log["poses"]
    texts = {
        "LISEZ-MOI.txt": READ_ME,
        **_journey("", scans[: len(place.truth)], place.odometry, place.truth),
        "boucles.csv": _table("a,b,x,y,theta", ([a, b, *guess] for a, b, guess in place.loops), "%.6g"),
        **_journey("tout/", scans, odometry, relative(poses[0], poses)),
    }
    return {name: text.encode() for name, text in texts.items()}


def _journey(folder: str, scans: Floats, odometry: Floats, truth: Floats) -> dict[str, str]:
    ranks = np.arange(len(truth), dtype=np.float64)
    return {
        f"{folder}scans.csv": _table(",".join(f"d{k}" for k in range(scans.shape[1])), scans, "%.2f"),
        f"{folder}odometrie.csv": _table("x,y,theta", odometry, "%.5f"),
        f"{folder}reference.tum": write_tum(Trajectory.from_planar(ranks, truth)),
    }


def _table(head: str, rows: Iterable[Iterable[float]], form: str) -> str:
    return "\n".join([head, *(",".join(form % value for value in row) for row in rows), ""])
