"""Checks on a map: the cases of one function on the module's map or on another one, told cell by cell."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Cases, Check, Failure, Rejection
from graders.core.code.drawable import to_drawable_array
from graders.core.compare import words as render
from graders.core.compare.shrinking import keep_unchanged
from graders.core.contract.findings import FigureData
from graders.core.contract.program import PlannedCalls, StudentFault
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20 import world
from graders.l20.predire2d.beliefs import SameBelief, at, in_words, shrink_belief, shrink_scan, support
from graders.l20.predire2d.cases import module_world
from reference.localisation.grid_filter import GridWorld, correct, predict

DEFAULT_SIGMA = 0.5
LEAST_EVIDENCE = 1e-2
LEAST_DOUBT = 1e-3
MANY_CELLS = 12


def corrected(grid: GridWorld, belief: Floats, scan: Floats, sigma: float = DEFAULT_SIGMA) -> Floats:
    """The reference, with the default of the contract."""
    return correct(grid, belief, scan, sigma)


REFERENCES: dict[str, Callable[..., Floats]] = {"predire2d": predict, "corriger2d": corrected}
NAMES: dict[str, tuple[str, ...]] = {"predire2d": ("bel", "du", "dv"), "corriger2d": ("bel", "scan_obs", "sigma")}
SHRINKERS = {
    "predire2d": (shrink_belief, keep_unchanged, keep_unchanged),
    "corriger2d": (shrink_belief, shrink_scan, keep_unchanged),
}


@dataclass(frozen=True, kw_only=True)
class BeliefCases(Cases):
    """Cases on one map. On the module's map beliefs are told by their cells; on another one they are shown whole."""

    grid: GridWorld

    def _rejection(self, failure: Failure) -> Rejection:
        rejection = super()._rejection(failure)
        elsewhere = self.grid is not module_world()
        got = to_drawable_array(failure.got, failure.args[0].shape)
        if failure.mismatch is not None:
            rejection.message = self._told(failure, got)
        rejection.args = (rejection.message,)
        if elsewhere:
            rejection.inputs = {"libres": self.grid.free, **(rejection.inputs or {})}
        else:
            self._by_cells(rejection, failure, got)
        return rejection

    def _told(self, failure: Failure, got: Floats | None) -> str:
        assert failure.mismatch is not None
        belief, *others = failure.args
        call = f"{self.function}(bel, {', '.join(_argument(other) for other in others)})"
        expected = (
            f"Si bel vaut {in_words(belief)} (cases notées (y, x)), {call} doit donner {in_words(failure.expected)}."
        )
        obtained = f" Vous obtenez {in_words(got)}." if got is not None else ""
        return f"{expected}{obtained} {failure.mismatch.message}"

    def _by_cells(self, rejection: Rejection, failure: Failure, got: Floats | None) -> None:
        belief = failure.args[0]
        if rejection.inputs is None or len(support(belief)) > MANY_CELLS:
            return
        others = {name: value for name, value in rejection.inputs.items() if name != self.names[0]}
        rejection.inputs = {"bel, cases (y, x) non nulles": by_cells(belief), **others}
        rejection.expected = by_cells(failure.expected)
        if got is not None:
            rejection.got = by_cells(got)


def _argument(value: Value) -> str:
    if isinstance(value, np.ndarray):
        return "[" + ", ".join(f"{z:.4g}" for z in value) + "]"
    return f"{value:.4g}"


def by_cells(belief: Floats) -> dict[str, float]:
    """A belief as {"(y, x)": probability}: its greatest values, and the sum of the others when there are many."""
    cells = support(belief)
    kept = sorted(sorted(cells, key=lambda cell: -abs(belief[cell]))[:MANY_CELLS])
    shown = {at(cell): float(belief[cell]) for cell in kept}
    if len(cells) > MANY_CELLS:
        shown["les autres, en tout"] = float(belief.sum() - sum(shown.values()))
    return shown


@dataclass(frozen=True, kw_only=True)
class OnGrid(Check):
    """The cases of one function on the module's map or, with `draw`, on one drawn afresh, where the file is run."""

    reports_call: ClassVar[bool] = True

    cases: Callable[[np.random.Generator, GridWorld], Iterator[Arguments]]
    draw: Callable[[np.random.Generator], GridWorld] | None = None
    judge: type[SameBelief] = SameBelief

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    @property
    def launches(self) -> int:
        return 0 if self.draw is None else 1

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        return self._on(module_world()).planned_calls(bench) if self.draw is None else ()

    def run(self, bench: Bench) -> None:
        if self.draw is None:
            return self._on(module_world()).run(bench)
        grid = self.draw(bench.rng)
        kit = world.kit(bench.rng, grid.free)
        cases = self._on(grid)
        try:
            with bench.run_with_kit(kit, *cases.planned_calls(bench)) as other:
                return cases.run(other)
        except StudentFault as fault:
            raise _not_loaded(grid, fault) from fault

    def _on(self, grid: GridWorld) -> BeliefCases:
        function = self.functions[0]
        takes_scan = function == "corriger2d"
        two = self.id == "sigma_par_defaut"
        return BeliefCases(
            id=self.id,
            title=self.title,
            points=self.points,
            functions=self.functions,
            hint=self.hint,
            grid=grid,
            names=NAMES[function][:2] if two else NAMES[function],
            cases=partial(_drawn, self.cases, grid),
            expected=partial(REFERENCES[function], grid),
            compare=self.judge(grid.free),
            shrinkers=SHRINKERS[function][:2] if two else SHRINKERS[function],
            valid=partial(tells_something, grid) if takes_scan else lambda args: True,
            figure=partial(beliefs_figure, grid),
        )


def _drawn(
    cases: Callable[[np.random.Generator, GridWorld], Iterator[Arguments]], grid: GridWorld, rng: np.random.Generator
) -> Iterator[Arguments]:
    return cases(rng, grid)


@dataclass(frozen=True, kw_only=True)
class OnGridBeside(OnGrid):
    """One that a function which does nothing passes."""

    requires_other_check: ClassVar[bool] = True


def _not_loaded(grid: GridWorld, fault: StudentFault) -> Rejection:
    height, width = grid.free.shape
    where = "".join(f"\n  {frame}" for frame in fault.frames)
    return Rejection(
        f"Relancé sur une autre carte (H = {height}, W = {width}), votre fichier s'arrête : {fault.message}{where}",
        inputs={"libres": grid.free},
        expected="un fichier qui se charge sur n'importe quelle carte",
        got=fault.message,
        cause=fault.outcome,
    )


def tells_something(grid: GridWorld, args: Arguments) -> bool:
    """Is the scan likely enough for every honest formula to agree, and a doubt between two cells not yet settled?"""
    belief, scan, *sigma = args
    misfits = np.sum((scan - grid.scans) ** 2, axis=2)
    products = belief * np.exp(-misfits / (2.0 * (sigma[0] if sigma else DEFAULT_SIGMA) ** 2))
    cells = support(belief)
    settled = len(cells) == 2 and min(products[cell] for cell in cells) < LEAST_DOUBT * products.sum()
    return bool(products.sum() > LEAST_EVIDENCE and not settled)


def beliefs_figure(grid: GridWorld, args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """What is drawn of one case: the map, the belief given, the one expected, the one obtained, the command if any."""
    command = [int(args[1]), int(args[2])] if not isinstance(args[1], np.ndarray) else None
    scan = None if command else [render.number(float(z), 3) for z in args[1]]
    return {
        "kind": "beliefs",
        "free": grid.free,
        "given": args[0],
        "expected": expected,
        "got": got,
        "command": command,
        "scan": scan,
    }
