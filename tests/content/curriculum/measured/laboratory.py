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
from reference.pose_graph import chordal_initial_guess, gauss_newton, loads_g2o
from reference.se2 import transform

Floats = NDArray[np.float64]

SOLUTIONS = Path(graders.__file__).parent / "l20"
#: Where the tests of `reference/` find the published sets.
DATA = Path(os.environ.get("BALISE_DATA") or Path(graders.__file__).parents[2] / "shared" / "data")
REACH, CONFIRMED, ASTRAY = 20.0, 0.6, 0.6


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
    """Errors in metres, of what each step comes to; how many loops were tried, confirmed by their share, and kept.

    `missed`: mean and standard deviation (rad) of the turns of odometry less the true ones, and once it is calibrated.
    """

    odometry: float
    first_chain: float
    constants: tuple[float, float, float]
    missed: tuple[float, float, float, float]
    calibrated: float
    chain: float
    least_share: float
    tried: int
    confirmed: int
    kept: int
    graph: float
    with_false: float
    without: float
    chained: Floats
    poses: Floats


def read(name: str) -> Floats:
    """A table of what is downloaded."""
    return np.asarray(np.loadtxt(io.BytesIO(intel.files()[name]), delimiter=",", skiprows=1))


def truth() -> Floats:
    return read_tum(intel.files()["reference.tum"].decode()).to_planar()


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


def killian_court() -> tuple[int, float, int, float, float, tuple[float, ...]]:
    """Poses; χ², steps and error (m) of Gauss-Newton from odometry; χ² of the chordal start, and at each step on."""
    packed = DATA / "pg2d" / "MITb.g2o"
    if not packed.is_file():
        pytest.skip("the published graph is not there: set BALISE_DATA to the folder of the data sets")
    content = loads_g2o(packed.read_text(), convention="difference")
    stuck = gauss_newton(content.graph, content.poses, max_iterations=100)
    start, _ = chordal_initial_guess(content.graph, content.poses)
    found = gauss_newton(content.graph, start)
    apart = absolute_trajectory_error(found.poses, stuck.poses).rmse
    return len(content.poses), stuck.chi2[-1], stuck.iterations, apart, found.chi2[0], found.chi2


@cache
def run() -> Found:
    odometry, loops, points = read("odometrie.csv"), read("boucles.csv"), clouds()
    own = functions("tp_slam")

    def steps(poses: Floats) -> Floats:
        return np.array([own["relatif"](a, b) for a, b in pairwise(poses)])

    def matched(moves: Floats) -> list[tuple[Floats, float]]:
        return [own["recaler"](points[k], points[k + 1], moves[k]) for k in range(len(moves))]

    def added_up(moves: Floats) -> Floats:
        poses = [np.zeros(3)]
        for step in moves:
            poses.append(np.asarray(own["composer"](poses[-1], step)))
        return np.array(poses)

    def ate(poses: Floats) -> float:
        return absolute_trajectory_error(truth(), np.asarray(poses)).rmse

    def solved(kept: list[tuple[int, int, Floats]]) -> Floats:
        return np.asarray(own["optimiser"](chain, matches, moves, kept))

    raw = steps(odometry)
    first = np.array([pose for pose, _ in matched(raw)])
    moves, constants = calibrated(raw, first)
    again = matched(moves)
    matches = np.array([pose for pose, _ in again])
    chain = added_up(matches)
    tried = [(int(a), int(b), *own["recaler"](points[int(a)], points[int(b)], z)) for a, b, *z in loops]
    confirmed = [(a, b, pose) for a, b, pose, share in tried if share > CONFIRMED]
    wanted = np.array([own["composer"](chain[a], pose)[:2] - chain[b, :2] for a, b, pose in confirmed])
    away = np.hypot(*(wanted - np.median(wanted, axis=0)).T)
    kept = [loop for loop, apart in zip(confirmed, away, strict=True) if apart < ASTRAY]
    turns = steps(truth())[:, 2]
    missed = [found[:, 2] - turns for found in (raw, moves)]
    graph = solved(kept)
    return Found(
        odometry=ate(odometry),
        first_chain=ate(added_up(first)),
        constants=constants,
        missed=(missed[0].mean(), missed[0].std(), missed[1].mean(), missed[1].std()),
        calibrated=ate(added_up(moves)),
        chain=ate(chain),
        least_share=min(share for _, share in again),
        tried=len(tried),
        confirmed=len(confirmed),
        kept=len(kept),
        graph=ate(graph),
        with_false=ate(solved(confirmed)),
        without=ate(solved([])),
        chained=chain,
        poses=graph,
    )


def calibrated(steps: Floats, matches: Floats) -> tuple[Floats, tuple[float, float, float]]:
    """The corrected steps, and the constants (alpha, beta, gamma), as the exercise `calibration` has them computed."""

    def ahead(moves: Floats) -> Floats:
        half = moves[:, 2] / 2
        return np.asarray(moves[:, 0] * np.cos(half) + moves[:, 1] * np.sin(half))

    A = np.column_stack([ahead(steps), steps[:, 2]])
    alpha, beta = np.linalg.lstsq(A, matches[:, 2], rcond=None)[0]
    gamma = ahead(steps) @ ahead(matches) / (ahead(steps) @ ahead(steps))
    turn = A @ [alpha, beta]
    half = (turn - steps[:, 2]) / 2
    c, s, x, y = np.cos(half), np.sin(half), gamma * steps[:, 0], gamma * steps[:, 1]
    return np.column_stack([c * x - s * y, s * x + c * y, turn]), (float(alpha), float(beta), float(gamma))
