"""A check of `integrer_scan` on a map of its own: every scan is judged, the first failing one shrunk, told by cells."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import MAX_FAULTS, Check, Rejection, fault_rejection
from graders.core.code.drawable import to_drawable_array
from graders.core.code.simplifying import shrink_and_reject
from graders.core.compare import words as render
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, KitSettings, PlannedCalls, StudentFault
from graders.core.contract.values import Floats, Value
from graders.l20.occupation.cases import Draw
from graders.l20.occupation.cells import Mask
from graders.l20.occupation.judge import Integration, Wrong, after, judge
from graders.robotics.poses import shrink_angle

FUNCTION = "integrer_scan"
FUNCTIONS = (FUNCTION,)
NAMES = ("l", "pose", "scan", "portee_max")
MANY_CELLS = 30
#: A simpler case must still show something: a ray that goes through that many judged cells.
FEWEST = 2


@dataclass(frozen=True)
class Failure:
    """A scan that a program fails on: what it answered, and why that is wrong; or the fault."""

    case: Integration
    value: Value
    wrong: Wrong | None
    fault: StudentFault | None

    @property
    def kind(self) -> object:
        """What a simpler failure must have in common with this one."""
        if self.fault is not None:
            return self.fault.exception, self.fault.outcome
        return self.wrong and (self.wrong.mismatch.slip, self.wrong.mismatch.cause, self.wrong.cell is None)

    @property
    def stops(self) -> bool:
        """Is it useless to go on?"""
        return self.fault is not None and (self.fault.fatal or self.fault.outcome is Outcome.MISSING_FUNCTION)


@dataclass(frozen=True, kw_only=True)
class Integrations(Check):
    """Judge each of the scans that `cases` draws, with the program started on the map of `kit`."""

    cases: Draw
    kit: KitSettings

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    @property
    def launches(self) -> int:
        return 1

    def run(self, bench: Bench) -> None:
        asked = PlannedCalls(FUNCTION, tuple(map(tuple, self.cases(bench.rng))), faults=MAX_FAULTS)
        try:
            with bench.run_with_kit(self.kit, asked) as other:
                self._run(other, asked)
        except StudentFault as fault:
            shape = np.shape(self.kit.parameters["libres"])
            message = f"Relancé sur une autre carte (H = {shape[0]}, W = {shape[1]}), votre fichier s’arrête : "
            raise Rejection(message + fault.message, inputs={}, got=fault.message, cause=fault.outcome) from fault

    def _run(self, bench: Bench, asked: PlannedCalls) -> None:
        first: Failure | None = None
        for args, answer in bench.iter_answers(asked):
            failure = _judged(Integration(*args), answer)
            fault = answer if isinstance(answer, StudentFault) else None
            value = None if fault is not None or isinstance(answer, StudentFault) else answer.value
            bench.observe(FUNCTION, value, ok=failure is None, fault=fault)
            first = first or failure
        if first is not None:
            _reject(bench, first)


def _judged(case: Integration, answer: Answer) -> Failure | None:
    if isinstance(answer, StudentFault):
        return Failure(case, None, None, answer)
    wrong = judge(case, answer.value)
    return Failure(case, answer.value, wrong, None) if wrong else None


def _reject(bench: Bench, failure: Failure) -> NoReturn:
    """With the same mistake on an empty grid, from the centre of a cell, along an axis, if it can be seen there."""

    def judged(case: Integration, answer: Answer) -> Failure | None:
        simpler = _judged(case, answer)
        return simpler if simpler is not None and simpler.kind == failure.kind else None

    shrink_and_reject(
        bench, FUNCTION, failure, failure.case, simpler_cases, judged, rejection,
        arguments=tuple, fair=_tells_enough, stops=lambda one: one.stops,
    )  # fmt: skip


def _tells_enough(case: Integration) -> bool:
    seen = case.told
    return bool((seen.crossed | seen.stopped | seen.either).sum() >= FEWEST)


def simpler_cases(case: Integration) -> Iterator[Integration]:
    """An empty grid; the robot in the middle of its cell; a simpler heading; whole scans stay as they were read."""
    if np.any(case.l):
        yield case._replace(l=np.zeros_like(case.l))
    if len(case.scan) > 1:
        return
    middle = np.array([*(np.floor(case.pose[:2]) + 0.5), case.pose[2]])
    if np.any(middle != case.pose):
        yield case._replace(pose=middle)
    for theta in shrink_angle(float(case.pose[2])):
        yield case._replace(pose=np.array([*case.pose[:2], theta]))
    half = np.floor(case.scan) + 0.5
    if np.any(half != case.scan):
        yield case._replace(scan=half)


def rejection(failure: Failure) -> Rejection:
    """A failure as the finding of a check, told by cells, with its figure."""
    case = failure.case
    inputs: dict[str, Value] = {
        f"l {case.l.shape}, cases (y, x) non nulles": by_cells(case.l, case.l != 0.0)
        or "aucune : l ne contient que des 0",
        "pose": case.pose,
        "scan": case.scan,
        "portee_max": case.portee_max,
    }
    grid = to_drawable_array(failure.value, case.l.shape)
    if failure.fault is not None:
        return fault_rejection(failure.fault, inputs=inputs, expected=_expected(case, None))
    assert failure.wrong is not None
    mismatch = failure.wrong.mismatch
    return Rejection(
        f"{_asked(case)} {mismatch.message}",
        inputs=inputs,
        expected=_expected(case, failure.wrong),
        got=failure.value if grid is None else _got(case, grid, failure.wrong),
        slip=mismatch.slip,
        cause=mismatch.cause,
        figure=scan_figure(case, grid, failure.wrong),
    )


def _asked(case: Integration) -> str:
    x, y, theta = case.pose
    spot, heading = (render.number(float(x), 4), render.number(float(y), 4)), render.number(float(theta), 4)
    where = f"Robot en x = {spot[0]}, y = {spot[1]}, cap {heading}"
    if len(case.scan) > 1:
        return f"{where}, scan de {len(case.scan)} rayons, portée {render.number(case.portee_max, 4)}."
    z = float(case.scan[0])
    return f"{where} ; un seul rayon, qui lit {render.number(z, 5)} (portée {render.number(case.portee_max, 4)})."


def _expected(case: Integration, wrong: Wrong | None) -> Value:
    """The judged cells that a ray changes; of whole scans, what must be seen in the wrong cell."""
    seen = case.told
    if len(case.scan) == 1:
        return by_cells(after(case), seen.crossed | seen.stopped | seen.either | _mask(case, wrong))
    if wrong is None or wrong.cell is None:
        return "une grille de la même forme que l"
    before = float(case.l[wrong.cell])
    wishes = ((seen.stopped, "plus que"), (seen.crossed, "moins que"), (seen.untouched, "exactement"))
    wish = next((word for mask, word in wishes if mask[wrong.cell]), "entre −5 et 5 ; avant :")
    return {_name(wrong.cell): f"{wish} {render.number(before, 4)}"}


def _got(case: Integration, grid: Floats, wrong: Wrong) -> Value:
    """The cells of the answer that are told: those expected, and those that have changed."""
    if len(case.scan) > 1:
        return by_cells(grid, _mask(case, wrong))
    seen = case.told
    return by_cells(grid, seen.crossed | seen.stopped | seen.either | (seen.untouched & (grid != case.l)))


def _mask(case: Integration, wrong: Wrong | None) -> Mask:
    mask = np.zeros(case.l.shape, dtype=bool)
    if wrong is not None and wrong.cell is not None:
        mask[wrong.cell] = True
    return mask


def by_cells(grid: Floats, mask: Mask) -> dict[str, Value]:
    """A grid as {"(y, x)": value} on a mask; the number of those left out when there are many."""
    cells = [(int(y), int(x)) for y, x in np.argwhere(mask)]
    shown: dict[str, Value] = {_name(cell): float(grid[cell]) for cell in cells[:MANY_CELLS]}
    return shown | ({"et": f"{len(cells) - MANY_CELLS} autres cases"} if len(cells) > MANY_CELLS else {})


def _name(cell: tuple[int, int]) -> str:
    return f"({cell[0]}, {cell[1]})"


def scan_figure(case: Integration, grid: Floats | None, wrong: Wrong | None) -> FigureData:
    """What is drawn: the rays, what surely becomes of each cell, what became of it, and where that is wrong."""
    seen = case.told
    wish = np.where(seen.stopped | seen.either, 1, np.where(seen.crossed, -1, 0))
    judged = seen.stopped | seen.crossed | seen.untouched | seen.either
    return {
        "kind": "scan",
        "wish": wish,
        "judged": judged,
        "before": np.round(case.l, 4),
        "after": np.round(after(case), 4) if len(case.scan) == 1 else None,
        "got": None if grid is None else np.round(grid, 4),
        "pose": case.pose,
        "scan": np.round(case.scan, 4),
        "portee_max": case.portee_max,
        "cell": None if wrong is None or wrong.cell is None else list(wrong.cell),
    }
