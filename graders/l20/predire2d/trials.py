"""The closed loop: a robot lost on the module's map moves eight times, slips, looks around, and must be found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from graders.core.code.batch_judging import answer_value
from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.drawable import to_drawable_array
from graders.core.compare.comparison import Mismatch, shape_mismatch, unreadable
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20.predire2d.beliefs import at
from graders.l20.predire2d.cases import MOVES, module_world, pick
from reference.localisation.grid_filter import Belief, Cell, GridWorld, correct, most_likely_cell, predict, sample_move

STEPS = 8
SIGMA = 0.5
EPISODES = 2
#: The walks are always the same: whether a wrong filter finds the robot nevertheless must not depend on the draw.
WALKS = 2026
NEAR = 1
MARGIN = 4.0
MAX_DRAWS = 4000
#: Commands as wrong programs take them: not at all, x for y, backwards. What they find must not depend on the draw.
MISLED: tuple[Callable[[int, int], tuple[int, int]], ...] = (
    lambda du, dv: (0, 0),
    lambda du, dv: (dv, du),
    lambda du, dv: (-du, -dv),
)
LOOP = "predire2d puis corriger2d"


@dataclass(frozen=True)
class Episode:
    """A walk: the commands, the cells really reached, and where the reference believes the robot to be at the end."""

    start: Cell
    commands: tuple[tuple[int, int], ...]
    cells: tuple[Cell, ...]
    belief: Belief

    @property
    def end(self) -> Cell:
        return self.cells[-1]


@lru_cache(maxsize=16)
def episodes(seed: int) -> tuple[Episode, ...]:
    """Walks that the reference follows, and that a filter which takes the commands for others does not.

    An honest program cannot fail by bad luck: the reference's belief is, near the truth, MARGIN times greater than
    anywhere else, and an honest one differs from it by rounding alone. Less than half of the walks drawn are rejected,
    so that none being left after MAX_DRAWS is out of the question (below 1e-900), and an error of ours.
    """
    rng = np.random.default_rng(seed)
    telling: list[Episode] = []
    for _ in range(MAX_DRAWS):
        episode = _walk(module_world(), rng)
        if _is_telling(module_world(), episode):
            telling.append(episode)
        if len(telling) == EPISODES:
            return tuple(telling)
    raise RuntimeError("the reference never localises the robot on the module's map")


def _walk(grid: GridWorld, rng: np.random.Generator) -> Episode:
    start = cell = pick(rng, grid.free)
    belief, commands, cells = grid.uniform_belief(), [], []
    for _ in range(STEPS):
        du, dv = MOVES[int(rng.integers(len(MOVES)))]
        cell = sample_move(grid, cell, du, dv, rng)
        belief = correct(grid, predict(grid, belief, du, dv), grid.scans[cell], SIGMA)
        commands.append((du, dv))
        cells.append(cell)
    return Episode(start, tuple(commands), tuple(cells), belief)


def _is_telling(grid: GridWorld, episode: Episode) -> bool:
    y, x = np.indices(grid.free.shape)
    close = np.maximum(np.abs(y - episode.end[0]), np.abs(x - episode.end[1])) <= NEAR
    if episode.belief[close].max() < MARGIN * episode.belief[~close].max():
        return False
    return all(gap(most_likely_cell(_misled(grid, episode, mislead)), episode.end) > NEAR for mislead in MISLED)


def _misled(grid: GridWorld, episode: Episode, mislead: Callable[[int, int], tuple[int, int]]) -> Belief:
    """Where a filter ends that takes each command for another one."""
    belief = grid.uniform_belief()
    for (du, dv), cell in zip(episode.commands, episode.cells, strict=True):
        belief = correct(grid, predict(grid, belief, *mislead(du, dv)), grid.scans[cell], SIGMA)
    return belief


def gap(cell: Cell, other: Cell) -> int:
    """How many cells apart, a diagonal step counting for one."""
    return max(abs(cell[0] - other[0]), abs(cell[1] - other[1]))


def _side_by_side(bench: Bench) -> Sequence[Sequence[Floats]]:
    """The student's beliefs of each walk, all walks being followed together: as many exchanges as one has steps.

    No step is asked before the one that leads to it is answered: what the reference believes there is what a right
    program answers, and must not lie in its process. None where an answer is no belief: walks are then followed one by
    one, up to the first that is told.
    """
    grid = module_world()
    beliefs: list[list[Floats]] = [[grid.uniform_belief()] for _ in episodes(WALKS)]
    for step in range(STEPS):
        moves: list[Arguments] = [episode.commands[step] for episode in episodes(WALKS)]
        scans: list[Arguments] = [(grid.scans[episode.cells[step]], SIGMA) for episode in episodes(WALKS)]
        for function, given in (("predire2d", moves), ("corriger2d", scans)):
            calls = [(walk[-1], *args) for walk, args in zip(beliefs, given, strict=True)]
            for walk, (_, answer) in zip(beliefs, bench.call_many(function, calls), strict=False):
                belief = to_drawable_array(answer_value(answer), grid.free.shape)
                if belief is None:
                    return ()
                walk.append(belief)
    return [walk[1:] for walk in beliefs if len(walk) > 2 * STEPS]


def localise(bench: Bench) -> None:
    """The student's two functions follow each walk; the greatest probability must end within one cell of the robot."""
    grid = module_world()
    followed = () if bench.runner.reenacting else _side_by_side(bench)
    failed: Rejection | None = None
    for place, episode in enumerate(episodes(WALKS)):
        beliefs: list[Floats] = []
        try:
            if len(followed) == EPISODES:
                beliefs.extend(followed[place])
            else:
                _follow(bench, grid, episode, beliefs)
        except (Rejection, StudentFault):
            bench.record_film(film(episode, beliefs))
            raise
        if failed is None and not bench.runner.reenacting:
            bench.record_film(film(episode, beliefs))
        belief = beliefs[-1]
        believed = most_likely_cell(belief)
        located = gap(believed, episode.end) <= NEAR
        bench.observe(LOOP, located, ok=located)
        if not located and failed is None:
            failed = _lost(grid, episode, believed, belief)
    if failed is not None:
        raise failed


def _follow(bench: Bench, grid: GridWorld, episode: Episode, beliefs: list[Floats]) -> None:
    """Has the student's functions follow a walk; each of their beliefs goes to the list, as they come."""
    belief: Floats = grid.uniform_belief()
    for (du, dv), cell in zip(episode.commands, episode.cells, strict=True):
        for function, args in (("predire2d", (du, dv)), ("corriger2d", (grid.scans[cell], SIGMA))):
            belief = _called(bench, grid, function, belief, *args)
            beliefs.append(belief)


def film(episode: Episode, beliefs: Sequence[Floats]) -> FigureData:
    """A walk, and the student's beliefs as far as there are: square roots of them as bytes, the greatest 255."""
    return {
        "kind": "localisation",
        "start": list(episode.start),
        "commands": [list(command) for command in episode.commands],
        "cells": [list(cell) for cell in episode.cells],
        "beliefs": [_shade(belief).tobytes().hex() for belief in beliefs],
    }


def _shade(belief: Floats) -> NDArray[np.uint8]:
    shown = np.clip(belief, 0.0, None)
    top = float(shown.max())
    return np.rint(255.0 * np.sqrt(shown / top if top > 0.0 else shown)).astype(np.uint8)


def _called(bench: Bench, grid: GridWorld, function: str, *args: Value) -> Floats:
    value = bench.call(function, *args)
    try:
        belief = read_array(value)
    except UnreadableError as error:
        raise _not_a_belief(bench, function, args, value, unreadable(error)) from error
    if belief.shape != grid.free.shape:
        raise _not_a_belief(bench, function, args, value, shape_mismatch(grid.free.astype(float), belief))
    if not np.all(np.isfinite(belief)):
        raise _not_a_belief(bench, function, args, value, Mismatch("Elle contient « nan » ou l'infini.", "nan"))
    return belief


def _not_a_belief(bench: Bench, function: str, args: tuple[Value, ...], value: Value, why: Mismatch) -> Rejection:
    bench.observe(LOOP, function, ok=False)
    rest = ("du", "dv") if function == "predire2d" else ("scan_obs", "sigma")
    return Rejection(
        f"Pendant la localisation, {function} ne renvoie pas une croyance. {why.message}",
        inputs=dict(zip(("bel", *rest), args, strict=True)),
        expected="un tableau (H, W) de probabilités",
        got=value,
        slip=why.slip if why.cause is Outcome.WRONG_ANSWER else None,
        cause=why.cause,
    )


def _lost(grid: GridWorld, episode: Episode, believed: Cell, belief: Floats) -> Rejection:
    away = gap(believed, episode.end)
    return Rejection(
        f"Départ inconnu, {STEPS} pas : le robot finit en (y, x) = {at(episode.end)}, mais votre croyance est maximale "
        f"en {at(believed)}, à {away} cases de lui.",
        inputs={
            "départ (inconnu du filtre)": list(episode.start),
            "ordres (du, dv)": [list(command) for command in episode.commands],
            "cases (y, x) atteintes": [list(cell) for cell in episode.cells],
        },
        expected=f"un maximum à une case au plus de {at(episode.end)}",
        got=f"un maximum en {at(believed)}",
        figure=_figure(grid, episode, belief),
    )


def _figure(grid: GridWorld, episode: Episode, belief: Floats) -> FigureData:
    sane = bool(np.all(np.abs(belief) < 1e9))
    return {
        "kind": "localisation",
        "free": grid.free,
        "path": [list(cell) for cell in (episode.start, *episode.cells)],
        "expected": episode.belief,
        "got": belief if sane else None,
    }
