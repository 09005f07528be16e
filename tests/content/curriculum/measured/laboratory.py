"""The real scans of the practical work, step by step, with the course's own solutions in the place of a student's.

`run` reads what is downloaded, and nothing else: a student has no more.
"""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import graders
from curriculum.l20.fichiers import intel
from reference.formats.trajectory_files import read_tum
from reference.metrics import absolute_trajectory_error
from reference.pose_graph import gauss_newton, loads_g2o
from reference.se2 import transform

Floats = NDArray[np.float64]

SOLUTIONS = Path(graders.__file__).parent / "l20"
#: Where the tests of `reference/` find the published sets.
DATA = Path(os.environ.get("BALISE_DATA") or Path(graders.__file__).parents[2] / "shared" / "data")
REACH, CONFIRMED = 20.0, 0.6


@cache
def functions(exercise: str) -> dict[str, Any]:
    """What a solution defines; those that come before are the course's."""
    room: dict[str, Any] = {"np": np}
    text = (SOLUTIONS / exercise / "solution.py").read_text(encoding="utf-8")
    for line in [line for line in text.splitlines() if line.startswith("from mes_fonctions")]:
        text = text.replace(line, "")
        for before in ("odometrie", "poses", "kabsch", "occupation", "slam_graphe"):
            room.update(functions(before))
    exec(text, room)
    return room


@dataclass(frozen=True)
class Found:
    """Errors in metres, of what each step comes to; how many loops were tried and kept."""

    odometry: float
    chain: float
    least_share: float
    tried: int
    kept: int
    graph: float
    without: float
    poses: Floats


def read(name: str) -> Floats:
    """A table of what is downloaded."""
    return np.asarray(np.loadtxt(io.BytesIO(intel.files()[name]), delimiter=",", skiprows=1))


def truth() -> Floats:
    return read_tum(intel.files()["reference.tum"].decode()).planar()


def clouds() -> list[Floats]:
    angles = -np.pi / 2 + np.pi * np.arange(180) / 180
    return [np.column_stack([one * np.cos(angles), one * np.sin(angles)])[one < REACH] for one in read("scans.csv")]


def reading() -> tuple[int, float, float]:
    """How many readings see nothing; of the first scan, what is on the right and ahead."""
    scans = read("scans.csv")
    return int((scans >= REACH).sum()), float(scans[0, 0]), float(scans[0, 90])


def squares() -> tuple[int, ...]:
    """Squares of 10 cm with a point in them: by odometry, by the graph, by the poses of the log."""
    counts = []
    for poses in (read("odometrie.csv"), run().poses, truth()):
        points = np.vstack([transform(pose, cloud) for pose, cloud in zip(poses, clouds(), strict=True)])
        counts.append(len(np.unique(np.floor(points / 0.1).astype(int), axis=0)))
    return tuple(counts)


def published() -> tuple[int, int, float, float]:
    """The published graph: poses, edges, χ² at first and after five steps. Skips where it is not there."""
    packed = DATA / "pg2d" / "INTEL.g2o"
    if not packed.is_file():
        pytest.skip("the published graph is not there: set BALISE_DATA to the folder of the data sets")
    content = loads_g2o(packed.read_text(), convention="difference")
    found = gauss_newton(content.graph, content.poses, max_iterations=5)
    own, graph = functions("slam_graphe"), content.graph
    errors = [
        own["erreur"](found.poses[i], found.poses[j], z) for i, j, z in zip(graph.i, graph.j, graph.z_i_j, strict=True)
    ]
    end = sum(float(error @ weight @ error) for error, weight in zip(errors, graph.information, strict=True))
    return len(content.poses), len(graph.z_i_j), found.chi2[0], end


@cache
def run() -> Found:
    odometry, loops, points = read("odometrie.csv"), read("boucles.csv"), clouds()
    own = functions("tp_slam")
    moves = [own["relatif"](a, b) for a, b in pairwise(odometry)]
    matched = [own["recaler"](points[k], points[k + 1], moves[k]) for k in range(len(moves))]
    matches = [pose for pose, _ in matched]
    chain = [np.zeros(3)]
    for step in matches:
        chain.append(np.asarray(own["composer"](chain[-1], step)))
    tried = [(int(a), int(b), *own["recaler"](points[int(a)], points[int(b)], z)) for a, b, *z in loops]
    kept = [(a, b, pose) for a, b, pose, share in tried if share > CONFIRMED]
    graph = own["optimiser"](np.array(chain), matches, moves, kept)
    without = own["optimiser"](np.array(chain), matches, moves, [])

    def ate(poses: Floats) -> float:
        return absolute_trajectory_error(truth(), np.asarray(poses)).rmse

    return Found(
        ate(odometry), ate(np.array(chain)), min(share for _, share in matched), len(tried), len(kept), ate(graph),
        ate(without), np.asarray(graph),
    )  # fmt: skip
