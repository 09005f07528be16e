"""What the stages of one grading hand to each other: the submission's own results, as long as they are sound.

A stage that fails hands on the course's result instead, so that the next one can still earn its points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, TypeVar
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

T = TypeVar("T")
Loop = tuple[int, int, Floats]
KEY_DISTANCE, KEY_TURN = 0.3, 0.4


@dataclass
class Results:
    """`odometry` (n, 3) of all scans; then of the k key poses: which scans they are, `matches` (k - 1, 3) of each to
    the one before, closed loops, and the optimised poses (k, 3). None where the stage has not succeeded."""

    odometry: Floats | None = None
    keys: list[int] | None = None
    matches: Floats | None = None
    loops: list[Loop] | None = None
    poses: Floats | None = None


@dataclass
class Chain:
    """One grading's results, with the course's where there is none. `borrowed` says that the last one asked for was."""

    own: Results = field(default_factory=Results)
    borrowed: bool = False

    @property
    def odometry(self) -> Floats:
        return self._taken(self.own.odometry, lambda: _course().odometry)

    @property
    def keys(self) -> list[int]:
        return self._taken(self.own.keys, lambda: _course().keys)

    @property
    def matches(self) -> Floats:
        """As many as there are key poses, but one: the course's only go with the course's keys."""
        return self._taken(self.own.matches if self._same_keys() else None, lambda: _course().matches)

    @property
    def loops(self) -> list[Loop]:
        return self._taken(self.own.loops if self._same_keys() else None, lambda: _course().loops)

    @property
    def poses(self) -> Floats:
        return self._taken(self.own.poses if self._same_keys() else None, lambda: _course().poses)

    def _same_keys(self) -> bool:
        return self.own.matches is None or len(self.own.matches) == len(self.keys) - 1

    def _taken(self, own: T | None, course: Callable[[], T | None]) -> T:
        if own is not None:
            return own
        self.borrowed = True
        lent = course()
        assert lent is not None, "the course's chain is whole"
        return lent


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
def _course() -> Results:
    """What the course's own solution finds on the simulated journey."""
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
    return Results(odometry, keys, matches, loops, np.asarray(ask("optimiser", start, matches, moves, loops)))


def truth_at(keys: Sequence[int]) -> Floats:
    return journeys.simulated().truth[list(keys)]
