"""Bug hunts: a wrong program of the catalogue, of which one looks for an input that shows its mistake.

An input shows a mistake where a check of the exercise tells the wrong program's answer from that of the reference. It
must be one on which all right programs that the exercise knows agree: outside of what a statement promises they may
differ, and nobody is told there that a program is wrong.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

import numpy as np

from graders.core.code.checks import Cases
from graders.core.code.contracts import FunctionContract
from graders.core.code.exercise import CodeDefinition
from graders.core.code.folder import Misconception, read_model
from graders.core.code.grading import CodeGrader
from graders.core.code.student_form import rewrite_as_student_form
from graders.core.compare.comparison import compare
from graders.core.compare.forms import ArrayForm, IndicesForm, NumberForm, ValueForm, WholeNumberForm, shape_text
from graders.core.compare.shrinking import iter_simpler_arguments
from graders.core.contract.program import Answer, KitSettings, Program, Programs, StudentFault
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments, Value
from graders.core.syntax_trees import parse_source

SEED = 20
#: Numbers of the longest input that a hunt may need, and of the longest that is read.
MAX_NEEDED, MAX_TYPED = 16, 120
#: Largest absolute value of a typed number.
LARGEST = 1e6
#: Cases of a check that are tried, numbers of one that is simplified, simpler inputs tried, in batches of so many.
MAX_CASES, MAX_SHRUNK, MAX_SHRINKS, SHRINK_BATCH = 40, 40, 150, 16
#: Other right versions of a model against which an input is held.
MAX_VERSIONS = 3


class InputSize(NamedTuple):
    """How much one has to type: numbers in all, and those that are not zero."""

    numbers: int
    nonzero: int


class InputFault(Exception):
    """An input cannot be taken; `argument` is the name of the one at fault, `message` says why, in French."""

    def __init__(self, argument: str, message: str) -> None:
        super().__init__(message)
        self.argument, self.message = argument, message


@dataclass(frozen=True)
class Hunt:
    """A misconception of one function, with the checks that compare its answers."""

    misconception: Misconception
    function: str
    contract: FunctionContract
    checks: tuple[Cases, ...]
    source: str

    def wrong_program_source(self, seed: int, public: Sequence[str] = ()) -> str:
        """Return the wrong program as a student would write it; `public` are the functions that the exercise asks."""
        return rewrite_as_student_form(self.source, self.function, seed, public=public)

    def read_input(self, values: Mapping[str, Value]) -> Arguments:
        """Return the arguments in the forms that programs are given. Raises InputFault."""
        sizes: dict[str, int] = {}
        optional = {name for name, _ in self.contract.defaults}
        args: Arguments = ()
        for name, form in self.contract.takes.items():
            if name not in values and name in optional:
                break
            if name not in values:
                raise InputFault(name, f"Donnez aussi {name} : {form.description}.")
            args = (*args, _read_typed_value(name, form, values[name], sizes))
        if measure_input(args).numbers > MAX_TYPED:
            raise InputFault(next(iter(self.contract.takes)), f"C’est trop long : {MAX_TYPED} nombres au plus en tout.")
        return args


@dataclass(frozen=True)
class HuntAnswer:
    """The answers to an input: `expected` of the reference, `got` of the wrong program (None where it stops).

    `fault` says how the wrong program stopped. `shows`: the mistake is seen.
    """

    expected: Value
    got: Value
    shows: bool
    fault: str = ""


class InputOutsideStatement(Exception):
    """Right programs differ on an input, or stop: the statement promises nothing there."""


#: What grades an exercise of code, before or after the course tells the requested functions.
CodeExercise = CodeDefinition | CodeGrader


def list_hunts(definition: CodeExercise) -> Iterator[Hunt]:
    """Yield the hunts that an exercise may have: at most one for each misconception and function."""
    if definition.long or definition.heavy:
        return
    contracts = {contract.function: contract for contract in definition.contracts}
    checks: dict[str, list[Cases]] = {}
    for check in definition.checks:
        if isinstance(check, Cases) and len(check.functions) == 1:
            checks.setdefault(check.function, []).append(check)
    seen = set()
    for misconception in definition.misconceptions:
        for function in misconception.functions:
            contract, key = contracts.get(function), (misconception.id, function)
            if contract is None or key in seen or function not in checks or not contract.takes:
                continue
            if all(map(_is_typeable_form, contract.takes.values())):
                seen.add(key)
                source = f"{extract_imports(definition.solution)}{misconception.source}"
                yield Hunt(misconception, function, contract, tuple(checks[function]), source)


def extract_imports(solution: str) -> str:
    """Return the imports of a solution: a model has none of its own."""
    nodes = [node for node in parse_source(solution).body if isinstance(node, ast.Import | ast.ImportFrom)]
    return "".join(f"{ast.unparse(node)}\n" for node in nodes)


def _is_typeable_form(form: ValueForm) -> bool:
    if isinstance(form, ArrayForm):
        fixed = [side for side in form.shape if isinstance(side, int)]
        return form.dtype == "float64" and len(form.shape) <= 2 and all(side <= 6 for side in fixed)
    return isinstance(form, NumberForm | IndicesForm)


def _read_typed_value(name: str, form: ValueForm, value: Value, sizes: dict[str, int]) -> Value:
    """Return one typed value in the form of an argument. Raises InputFault."""
    wanted = f"{name} doit être {form.description}"
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputFault(name, f"{wanted}, avec des nombres seulement, et des lignes de même longueur.") from None
    if array.size and not (np.isfinite(array).all() and np.abs(array).max() <= LARGEST):
        raise InputFault(name, f"{name} a un nombre trop grand, infini ou nan : restez sous un million.")
    if isinstance(form, NumberForm):
        if array.shape != ():
            raise InputFault(name, f"{wanted}, et vous donnez {_typed_shape_text(array)}.")
        if isinstance(form, WholeNumberForm):
            if array != np.round(array):
                raise InputFault(name, f"{wanted} : {float(array):g} n’en est pas un.")
            return int(array)
        return float(array)
    if isinstance(form, IndicesForm):
        if array.ndim != 1 or np.any(array != np.round(array)):
            raise InputFault(name, f"{wanted} : une liste d’entiers, comme [0, 2].")
        return [int(item) for item in array]
    if not form.matches(array, sizes):
        raise InputFault(name, f"{wanted}, et vous donnez {_typed_shape_text(array)}.{_sizes_text(sizes)}")
    return array


def _typed_shape_text(array: np.ndarray) -> str:
    return "un seul nombre" if array.shape == () else f"un tableau {shape_text(array.shape)}"


def _sizes_text(sizes: Mapping[str, int]) -> str:
    """« Ici, n vaut 3. »"""
    return f" Ici, {' et '.join(f'{name} vaut {size}' for name, size in sizes.items())}." if sizes else ""


def measure_input(args: Arguments) -> InputSize:
    """Return the size of an input."""
    arrays = [np.asarray(value, dtype=np.float64) for value in args]
    return InputSize(sum(array.size for array in arrays), sum(int(np.count_nonzero(array)) for array in arrays))


class HuntPrograms:
    """The programs of an exercise on which inputs are tried; closed with it."""

    def __init__(self, definition: CodeExercise, programs: Programs) -> None:
        self._programs = programs
        self.kit: KitSettings = definition.kit(stream(SEED, "kit"))
        imports = extract_imports(definition.solution)
        model = read_model(definition.folder)
        versions = [version.text for version in model.correct_versions()][: MAX_VERSIONS + 1] if model else []
        self._right = [self.open(text) for text in (definition.solution, *(imports + text for text in versions))]

    def open(self, source: str) -> Program:
        return self._programs.open(source.encode(), self.kit)

    def close(self) -> None:
        for program in self._right:
            program.close()

    def try_input(self, hunt: Hunt, wrong: Program, args: Arguments) -> HuntAnswer:
        """Return what an input shows. Raises InputOutsideStatement."""
        answer = next(self.try_inputs(hunt, wrong, [args]))
        if answer is None:
            raise InputOutsideStatement
        return answer

    def try_inputs(self, hunt: Hunt, wrong: Program, inputs: Sequence[Arguments]) -> Iterator[HuntAnswer | None]:
        """Yield what each input shows, None of one on which right programs differ or stop."""
        reference, *others = [_answer_each_input(program, hunt.function, inputs) for program in self._right]
        wrongs = _answer_each_input(wrong, hunt.function, inputs)
        for k, args in enumerate(inputs):
            right = reference[k]
            checks = [check for check in hunt.checks if check.valid(args)] or list(hunt.checks)
            if isinstance(right, StudentFault) or any(
                _is_wrong_answer(checks, right.value, other[k]) for other in others
            ):
                yield None
                continue
            got = wrongs[k]
            if isinstance(got, StudentFault):
                yield HuntAnswer(right.value, None, True, got.message)
            else:
                yield HuntAnswer(right.value, got.value, _is_wrong_answer(checks, right.value, got))


def _answer_each_input(program: Program, function: str, inputs: Sequence[Arguments]) -> list[Answer]:
    """Return one answer for each input; a program that has stopped for good gives its last fault."""
    answers = list(program.call_many(function, inputs))
    return answers + answers[-1:] * (len(inputs) - len(answers))


def _is_wrong_answer(checks: Sequence[Cases], expected: Value, answer: Answer) -> bool:
    if isinstance(answer, StudentFault):
        return True
    return any(compare(check.compare, expected, answer.value) is not None for check in checks)


def find_witness(hunt: Hunt, ground: HuntPrograms, wrong: Program) -> Arguments | None:
    """Return a small input that shows the mistake; None where no case of the checks gives one of the bounded size."""
    for check in hunt.checks:
        cases = [tuple(args) for args, _ in zip(check.cases(stream(SEED, check.id)), range(MAX_CASES), strict=False)]
        short = [args for args in cases if measure_input(args).numbers <= MAX_SHRUNK]
        showing = filter_showing_inputs(hunt, ground, wrong, short)
        shrunk = [_shrink_input(hunt, ground, wrong, check, args) for args in sorted(showing, key=_reading_cost)[:1]]
        if shrunk and measure_input(shrunk[0]).numbers <= MAX_NEEDED:
            return shrunk[0]
    return None


def _reading_cost(args: Arguments) -> tuple[int, int, int]:
    size = measure_input(args)
    return size.nonzero, size.numbers, sum(len(f"{number:.6g}") for number in _flatten_numbers(args))


def _flatten_numbers(args: Arguments) -> list[float]:
    return [float(number) for value in args for number in np.ravel(np.asarray(value, dtype=np.float64))]


def filter_showing_inputs(
    hunt: Hunt, ground: HuntPrograms, wrong: Program, inputs: Sequence[Arguments]
) -> list[Arguments]:
    """Return the inputs that show the mistake, of those that one may type."""
    typed = [args for args in inputs if _is_typeable_input(hunt, args)]
    answers = ground.try_inputs(hunt, wrong, typed)
    return [args for args, answer in zip(typed, answers, strict=True) if answer is not None and answer.shows]


def _is_typeable_input(hunt: Hunt, args: Arguments) -> bool:
    try:
        hunt.read_input(dict(zip(hunt.contract.takes, args, strict=False)))
    except InputFault:
        return False
    return True


def _shrink_input(hunt: Hunt, ground: HuntPrograms, wrong: Program, check: Cases, args: Arguments) -> Arguments:
    """Return a simpler input that still shows the mistake, tried in batches."""
    tries = 0
    while tries < MAX_SHRINKS:
        simpler = (candidate for candidate in iter_simpler_arguments(check.shrinkers, args) if check.valid(candidate))
        showing: list[Arguments] = []
        while not showing and tries < MAX_SHRINKS and (batch := list(islice(simpler, SHRINK_BATCH))):
            tries += len(batch)
            showing = filter_showing_inputs(hunt, ground, wrong, batch)
        if not showing:
            break
        args = showing[0]
    return args
