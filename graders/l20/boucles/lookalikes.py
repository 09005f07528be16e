"""Walks on the module's map that never change, made of places that a poor comparison confuses and a good one does not.

Each look-alike and the place to recognise have one number in common: that of a scan, the norm or the sum of a usual
signature, one component of it; or no component of a usual signature is higher there, or lower. By this number, or by
the largest difference with its sign, it is as near as another reading of the place itself, or nearer. By each
descriptor and distance of the family it is twice farther or more.

The poses were found among 240 000 at random; the tests hold what they are for.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.boucles.places import BEAMS, NOISE, module_map
from graders.l20.boucles.walks import Walk, turned
from reference.world.raycast import cast_scans

Pose = tuple[float, float, float]

#: The places to recognise, of as many walks, and the seeds of the noise of their scans.
HERE: tuple[Pose, ...] = ((20.347, 2.155, 0.093), (6.788, 11.324, -2.307), (3.366, 5.79, 0.487))
NOISES = (118442, 10018014, 10098258)
#: Beams by which the place is turned when it is seen again, and how many scans are too recent.
TURN, RECENT = 5, 9

#: What each one is for, what it shares with the place to recognise, in French where that is soon said, and its poses.
OTHERS: tuple[tuple[str, str | None, tuple[Pose, ...]], ...] = (
    ("mean", "la même moyenne", ((8.135, 1.29, 1.417), (8.332, 1.36, 0.553), (11.891, 11.31, 3.05))),
    ("std", "le même écart-type", ((4.133, 3.35, -1.357), (22.865, 14.337, -0.22), (4.211, 3.612, 2.878))),
    ("longest", "le même rayon le plus long",
     ((1.336, 1.231, -1.154), (13.783, 10.157, 2.621), (2.331, 13.719, -0.146))),
    ("shortest", "le même rayon le plus court",
     ((18.113, 12.778, -2.281), (18.183, 12.355, -1.753), (17.726, 2.697, -2.778))),
    ("median", "la même médiane", ((11.269, 9.327, -3.071), (11.602, 9.656, -2.249), (9.732, 2.823, 0.565))),
    ("span", "le même écart entre le rayon le plus long et le plus court",
     ((11.399, 5.74, 0.426), (18.76, 5.859, -2.851), (7.716, 13.204, 2.03))),
    ("sum of squares", "la même somme des carrés",
     ((8.669, 10.346, -0.626), (1.139, 5.637, -3.017), (12.242, 12.342, -0.778))),
    ("first harmonic", "le même premier coefficient de Fourier, en module",
     ((5.236, 14.787, 1.982), (10.668, 4.708, 3.077), (16.281, 11.337, 1.717))),
    ("norm of the spectrum", "un spectre de même norme",
     ((6.718, 1.164, 1.062), (5.227, 1.145, 1.744), (16.864, 12.191, 1.034))),
    ("sum of the spectrum", "un spectre de même somme",
     ((6.828, 5.819, -2.075), (15.178, 10.303, -0.63), (18.747, 11.368, -0.978))),
    ("sum of both sides", "un spectre de même somme",
     ((15.681, 10.234, 0.643), (22.607, 1.274, 1.54), (13.643, 2.245, 3.009))),
    ("norm without the mean", "un spectre de même norme, la moyenne mise à part",
     ((21.188, 14.704, 2.186), (3.836, 3.781, 1.338), (5.729, 3.605, 1.94))),
    ("norm of four statistics", None, ((1.304, 5.616, -1.463), (19.35, 14.733, -2.459), (7.386, 11.295, -0.69))),
    ("sum of four statistics", None, ((8.873, 14.886, -2.678), (16.129, 1.245, -2.454), (21.315, 4.204, -2.457))),
    ("norm of the power", None, ((18.229, 14.699, 1.585), (14.283, 13.877, 2.701), (12.264, 11.214, -0.858))),
    ("norm of 10 boxes", None, ((12.321, 8.889, 0.644), (7.623, 3.183, -0.284), (8.802, 7.663, -0.931))),
    ("norm of 20 boxes", None, ((7.388, 3.711, 0.539), (8.142, 5.705, 0.518), (12.306, 7.102, 0.728))),
    ("norm of the quartiles", None, ((22.85, 10.614, -0.111), (8.846, 14.357, -2.012), (2.338, 2.238, 0.317))),
    ("sum of the quartiles", None, ((21.796, 10.162, 0.271), (14.89, 1.111, 2.37), (21.612, 3.609, -1.962))),
    ("sum of mean and std", None, ((1.144, 10.172, 0.794), (1.231, 10.325, -2.15), (11.373, 12.265, 2.468))),
    ("last harmonic", None, ((15.225, 14.855, 0.339), (6.828, 5.819, -2.075), (2.33, 12.697, -1.221))),
    ("largest harmonic", None, ((11.236, 4.33, 1.659), (20.283, 13.298, -1.639), (5.399, 2.375, 2.152))),
    ("first lag", None, ((22.387, 1.326, -3.1), (22.374, 10.235, -0.946), (16.132, 13.378, -0.853))),
    ("norm of 12 boxes", None, ((8.12, 5.228, 2.777), (14.839, 5.365, 0.173), (8.819, 2.874, 0.415))),
    ("one rank", None, ((4.864, 14.849, -1.396), (4.142, 14.849, -0.531), (5.603, 4.834, 0.588))),
    ("one amplitude", None, ((22.897, 14.643, -1.057), (1.287, 14.849, 1.114), (2.364, 11.222, -1.429))),
    ("no longer, once sorted", None, ((16.656, 5.206, 1.318), (19.372, 6.291, 0.493), (17.686, 4.799, 0.326))),
    ("no shorter, once sorted", None, ((5.206, 3.367, 1.997), (10.287, 5.688, 1.656), (10.712, 5.21, 0.577))),
    ("no stronger", None, ((20.782, 13.344, 0.993), (17.38, 4.171, 1.398), (21.283, 13.278, 1.242))),
    ("no weaker", None, ((14.323, 13.883, -2.006), (11.259, 8.826, 2.883), (9.109, 3.801, -0.78))),
    ("one more in some of 10 boxes", None,
     ((16.397, 10.878, -1.316), (12.148, 11.125, -2.286), (18.395, 10.244, 0.154))),
    ("one less in some of 10 boxes", None,
     ((4.112, 11.208, -1.053), (16.716, 13.748, -2.883), (17.847, 10.196, -1.077))),
    ("one more in some of 12 boxes", None,
     ((11.113, 10.832, 2.897), (15.858, 13.356, 2.249), (13.894, 13.119, -2.327))),
    ("one less in some of 12 boxes", None,
     ((16.609, 13.742, -0.926), (17.69, 2.734, -0.739), (5.853, 10.679, -0.846))),
    ("lower", None, ((21.68, 13.309, 1.386), (17.374, 3.847, 2.226), (20.219, 13.173, -2.91))),
    ("higher", None, ((12.605, 6.841, 2.051), (9.206, 3.8, -1.466), (9.67, 7.121, 1.734))),
)  # fmt: skip


@lru_cache(maxsize=len(HERE))
def lookalikes(again: int) -> Walk:
    """The place to recognise, all that look like it, recent scans of some of these, the same place; `again` is which.

    `places` are 0 for this place, then 1 for the first look-alike and so on.
    """
    others = [poses[again] for _, _, poses in OTHERS]
    visited = np.array([HERE[again], *others])
    places = np.array([*range(len(visited)), *range(1, 1 + RECENT), 0])
    poses = np.array([turned(visited[0], TURN), *visited[places[1:]]])
    scans = cast_scans(module_map(), poses, BEAMS, world.RANGE)
    alike = {j: shared for j, (_, shared, _) in enumerate(OTHERS, start=1) if shared is not None}
    return Walk(poses, _read(scans, NOISES[again]), places, (len(places) - 1,), NOISE, alike)


def _read(scans: Floats, seed: int) -> Floats:
    return np.clip(scans + np.random.default_rng(seed).normal(0.0, NOISE, scans.shape), 0.0, world.RANGE)
