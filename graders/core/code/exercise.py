"""Definition of an exercise of code by its grader's folder, before the course tells the requested functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from graders.core.code.checks import Check
from graders.core.code.contracts import FunctionContract, add_defaults_and_tolerances
from graders.core.code.explaining import KitMaker
from graders.core.code.folder import (
    Misconception,
    check_known_functions,
    read_misconceptions,
    read_model,
    read_solution,
)
from graders.core.code.grading import CodeGrader
from graders.core.code.mutations import Edit, Mutant
from graders.core.code.prober import Prober
from graders.core.code.probes import Probes
from graders.core.contract.definition import Definition
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.program import KitSettings
from graders.core.contract.verdict import MAX_POINTS


@dataclass(frozen=True)
class CodeDefinition(Definition):
    """See `code`."""

    checks: tuple[Check, ...]
    kit: KitMaker
    solution: str
    misconceptions: tuple[Misconception, ...] = ()
    prober: Prober | None = None
    long: bool = False
    heavy: bool = False
    contracts: tuple[FunctionContract, ...] = ()

    @property
    def judged_functions(self) -> frozenset[str]:
        """The functions that some check tests."""
        return frozenset(function for check in self.checks for function in check.functions)

    def bind(self, functions: Sequence[str]) -> CodeGrader:
        """Return the grader of an exercise that asks for `functions`.

        Raises MalformedExerciseError where a check or misconception names another function, or one has no check.
        """
        odd = sorted(self.judged_functions ^ set(functions))
        if odd:
            raise MalformedExerciseError(
                self.file,
                f"fonctions demandées et non corrigées, ou l’inverse : {', '.join(odd)} (exercise.toml dit lesquelles)",
            )
        check_known_functions(self.folder, self.misconceptions, functions)
        if unasked := [each.function for each in self.contracts if each.function not in functions]:
            raise MalformedExerciseError(self.file, f"contrat d’une fonction qui n’est pas demandée : {unasked[0]}")
        return CodeGrader(
            self.exercise, self.folder, tuple(functions), self.checks, self.kit, self.misconceptions, self.solution,
            prober=self.prober, long=self.long, heavy=self.heavy, contracts=self.contracts,
        )  # fmt: skip


def seeded_kit(module: str) -> KitMaker:
    """Return the maker of a module's kit whose only parameter is a seed."""
    return lambda rng: KitSettings(module, {"seed": int(rng.integers(2**62))})


def code(
    file: str,
    *,
    checks: Sequence[Check],
    kit: KitMaker | None = None,
    probes: Sequence[Probes] = (),
    long: bool = False,
    heavy: bool = False,
    contracts: Sequence[FunctionContract] = (),
) -> CodeDefinition:
    """Describe an exercise from its grader's module: `code(__file__, checks=…, kit=…)`.

    `kit` makes the settings of an execution; by default, a seed for `rng`. `probes` are called when checks failed, and
    the answers compared with the model's mutants. `contracts` say what each function is given and may return. A `long`
    exercise takes seconds to grade any program, and is not rehearsed. A `heavy` one takes about a second to grade a
    right program, at most a fifth of it for warming up: only a mistake is rehearsed.

    Raises MalformedExerciseError when the folder is inconsistent.
    """
    folder = Path(file).parent
    total = sum(check.points for check in checks)
    if abs(total - MAX_POINTS) > 1e-9:
        raise MalformedExerciseError(
            Path(file),
            f"les vérifications font {total:g} points : changez « points » pour qu’elles en fassent {MAX_POINTS:g}",
        )
    if len({check.id for check in checks}) != len(checks):
        raise MalformedExerciseError(Path(file), "deux vérifications ont le même « id »")
    solution = read_solution(folder)
    misconceptions = tuple(read_misconceptions(folder, solution))
    model = read_model(folder)
    whole = [
        Mutant((m.id,), m.source, (Edit(m.id, (), frozenset(m.functions)),))
        for m in misconceptions
        if m.whole and not m.ruled
    ]
    prober = Prober(model, probes, whole) if model is not None else None
    return CodeDefinition(
        folder, tuple(checks), kit or seeded_kit(folder.parent.name), solution, misconceptions, prober, long, heavy,
        add_defaults_and_tolerances(contracts, checks, solution),
    )  # fmt: skip
