"""Real scans of the practical work, as they are downloaded: the beginning of a log of the Intel laboratory.

`files()` gives what is downloaded, by name.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graders.l20.tp_slam.journeys import LOG, indoor
from reference.formats.trajectory_files import Trajectory, write_tum

READ_ME = """Cent vingt scans du laboratoire d'Intel, à Seattle (TP « SLAM et navigation », partie A bis)

Enregistrés par Dirk Hähnel sur un vrai robot ; jeu de données du banc d'essai SLAM de Fribourg.
Unités : mètres, radians.

scans.csv        un scan par ligne, 180 distances ; le rayon k vise l'angle -pi/2 + pi*k/180 depuis le cap
                 une lecture de 20 m ou plus ne voit rien
odometrie.csv    x, y, theta : une odométrie par scan, depuis la pose nulle. Le journal ne garde plus la sienne :
                 celle-ci a été refaite par nous, avec des erreurs tirées au hasard
boucles.csv      a, b, x, y, theta : deux scans qui voient les mêmes murs, et une idée grossière de la pose
                 de b vue de a
reference.tum    t x y z qx qy qz qw : les poses que le journal donne, trouvées par un SLAM à grille ; t est un rang
                 pour mesurer vos erreurs à la fin seulement
"""


def files() -> dict[str, bytes]:
    """Name to content."""
    place = indoor()
    with np.load(LOG) as log:
        scans = log["centimetres"] / 100.0
    ranks = np.arange(len(place.truth), dtype=np.float64)
    texts = {
        "LISEZ-MOI.txt": READ_ME,
        "scans.csv": _table(",".join(f"d{k}" for k in range(scans.shape[1])), scans, "%.2f"),
        "odometrie.csv": _table("x,y,theta", place.odometry, "%.6f"),
        "boucles.csv": _table("a,b,x,y,theta", ([a, b, *guess] for a, b, guess in place.loops), "%.6g"),
        "reference.tum": write_tum(Trajectory.from_planar(ranks, place.truth)),
    }
    return {name: text.encode() for name, text in texts.items()}


def _table(head: str, rows: Iterable[Iterable[float]], form: str) -> str:
    return "\n".join([head, *(",".join(form % value for value in row) for row in rows), ""])
