"""What the stages of one grading hand to each other: the submission's own results, as long as they are sound.

A stage that fails hands on the course's result instead, so that the next one can still earn its points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.runner import Runner
from graders.core.contract.local import LocalProgram
from graders.core.contract.values import Floats
from graders.l20 import parcours, world
from graders.l20.tp_slam import journeys
from reference.metrics import absolute_trajectory_error
from reference.se2 import relative

Loop = tuple[int, int, Floats]
KEY_DISTANCE, KEY_TURN = 0.3, 0.4


@dataclass
class Results:
    """`odometry` (n, 3) of all scans; then of the k key poses: which scans they are, `matches` (k - 1, 3) of each to
    the one before, closed loops, and the optimised poses (k, 3) of `solved_keys`. None where a stage has failed.
    """

    odometry: Floats | None = None
    keys: list[int] | None = None
    matches: Floats | None = None
    loops: list[Loop] | None = None
    poses: Floats | None = None
    solved_keys: list[int] | None = None


@dataclass(frozen=True)
class CourseResults:
    """What the course's own solution finds on the simulated journey, as in `Results`."""

    odometry: Floats
    keys: list[int]
    matches: Floats
    loops: list[Loop]
    poses: Floats


@dataclass
class Chain:
    """One grading's results, with the course's where there is none. `borrowed` says that the last one asked for was."""

    own: Results = field(default_factory=Results)
    borrowed: bool = False

    @property
    def odometry(self) -> Floats:
        return self._lend().odometry if self.own.odometry is None else self.own.odometry

    @property
    def keys(self) -> list[int]:
        return self._lend().keys if self.own.keys is None else self.own.keys

    def matched(self) -> tuple[list[int], Floats]:
        """Return the key poses and their matches, which go together: both of the course where these are missing."""
        if self.own.matches is not None:
            return self.keys, self.own.matches
        course = self._lend()
        return course.keys, course.matches

    def closed(self) -> tuple[list[int], Floats, list[Loop]]:
        """Return the key poses, their matches and the loops between them, which go together.

        Where the loops are missing, those of the course are lent with its matches, unless its key poses are the same.
        """
        keys, matches = self.matched()
        if self.own.loops is not None:
            return keys, matches, self.own.loops
        course = self._lend()
        return course.keys, matches if keys == course.keys else course.matches, course.loops

    def solved(self) -> tuple[list[int], Floats]:
        """Return the optimised poses and which scans they are of."""
        if self.own.poses is not None and self.own.solved_keys is not None:
            return self.own.solved_keys, self.own.poses
        course = self._lend()
        return course.keys, course.poses

    def _lend(self) -> CourseResults:
        self.borrowed = True
        return _course()


_CHAINS: WeakKeyDictionary[Runner, Chain] = WeakKeyDictionary()


def chain_of(bench: Bench) -> Chain:
    """That of the program on the bench."""
    found = _CHAINS.setdefault(bench.runner, Chain())
    found.borrowed = False
    return found


def steps_of(poses: Floats) -> Floats:
    """Each pose seen from the one before."""
    return np.asarray(relative(poses[:-1], poses[1:]))


def ate(poses: Floats, truth: Floats) -> float:
    """In metres, after the best rigid alignment."""
    return absolute_trajectory_error(truth, poses, "rigid").rmse


@cache
def _course() -> CourseResults:
    run, solved = journeys.simulated(), LocalProgram(Path(__file__).with_name("solution.py").read_bytes(), world.STILL)

    def ask(function: str, *args: Any) -> Any:
        return solved.call(function, *args).value

    odometry = np.asarray(ask("trajectoire", run.wheels, parcours.TRACK))
    keys: list[int] = ask("poses_cles", odometry)
    clouds = [journeys.cloud(run.scans[k]) for k in keys]
    moves = steps_of(odometry[keys])
    matches = np.array([ask("recaler", clouds[k], clouds[k + 1], moves[k])[0] for k in range(len(moves))])
    start = journeys.added_up(matches)
    loops: list[Loop] = ask("fermetures", run.scans[keys], start)
    return CourseResults(odometry, keys, matches, loops, np.asarray(ask("optimiser", start, matches, moves, loops)))


def truth_at(keys: Sequence[int]) -> Floats:
    return journeys.simulated().truth[list(keys)]
