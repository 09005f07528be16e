"""Advice that holds: each edit is run beside the program that it changes, and both beside the reference.

No advice is better than a wrong one: an edit counts where its program gives the same answers to the checks' own cases,
and, if time is its reason, where it was measured to take less.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from graders.core.advice.edits import Advice, AdviceKind
from graders.core.advice.remarks import list_advice
from graders.core.code.checks import Cases
from graders.core.code.exercise import CodeDefinition
from graders.core.code.grading import CodeGrader
from graders.core.compare.comparison import compare
from graders.core.contract.program import Answer, KitSettings, Programs, StudentFault
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments

SEED = 20
MAX_CASES, MAX_SHOWN = 12, 3
#: How many times faster an edit must be to be told for its time.
MIN_GAIN = 1.15
TIMED = frozenset({AdviceKind.loop, AdviceKind.repeated})
#: Appended to a program: the seconds that a call takes, the best of a few, each on arguments of its own.
HARNESS = """

def duree_mesuree_de_{function}(*entrees):
    import copy, time
    durees = []
    for _ in range(5):
        propres = copy.deepcopy(entrees)
        debut = time.perf_counter()
        {function}(*propres)
        durees.append(time.perf_counter() - debut)
    return min(durees)
"""


@dataclass(frozen=True)
class TriedAdvice:
    """Advice that holds; `gain` is how many times less time its program takes."""

    advice: Advice
    gain: float


@dataclass(frozen=True)
class Review:
    """The advice on a program, and how many times the reference's time it takes (0: not measured)."""

    advice: tuple[TriedAdvice, ...]
    ratio: float


@dataclass(frozen=True)
class _MeasuredRun:
    answers: Sequence[Answer]
    seconds: float


def review_program(definition: CodeDefinition | CodeGrader, source: str, programs: Programs) -> Review:
    """Run a program that passes, its edits and the reference on the checks' cases. The caller chooses the walls."""
    cases = _cases_of_checks(definition)
    if not cases:
        return Review((), 0.0)
    kit = definition.kit(stream(SEED, "kit"))
    own, reference = (_measure_run(programs, kit, text, cases) for text in (source, definition.solution))
    if own is None or reference is None:
        return Review((), 0.0)
    asked = {check.function for check, _ in cases}
    return Review(
        _try_all_advice(programs, kit, cases, own, source, asked, definition.solution), own.seconds / reference.seconds
    )


def _cases_of_checks(definition: CodeDefinition | CodeGrader) -> Sequence[tuple[Cases, Sequence[Arguments]]]:
    if definition.long or definition.heavy:
        return ()
    checks = [check for check in definition.checks if isinstance(check, Cases) and len(check.functions) == 1]
    return [
        (check, [tuple(args) for args, _ in zip(check.cases(stream(SEED, check.id)), range(MAX_CASES), strict=False)])
        for check in checks
    ]


def _try_all_advice(
    programs: Programs,
    kit: KitSettings,
    cases: Sequence[tuple[Cases, Sequence[Arguments]]],
    own: _MeasuredRun,
    source: str,
    asked: Collection[str],
    reference: str,
) -> tuple[TriedAdvice, ...]:
    kept: list[TriedAdvice] = []
    for advice in list_advice(source, asked, reference):
        if any(advice.line == other.advice.line for other in kept):
            continue
        edited = _measure_run(programs, kit, advice.source, cases)
        if edited is None or not _are_same_answers(cases, own.answers, edited.answers):
            continue
        gain = own.seconds / edited.seconds
        if gain >= MIN_GAIN or advice.kind not in TIMED:
            kept.append(TriedAdvice(advice, gain))
        if len(kept) == MAX_SHOWN:
            break
    return tuple(kept)


def _measure_run(
    programs: Programs, kit: KitSettings, source: str, cases: Sequence[tuple[Cases, Sequence[Arguments]]]
) -> _MeasuredRun | None:
    """Return the answers of a program and the seconds that they take; None where a call fails."""
    names = dict.fromkeys(check.function for check, _ in cases)
    text = source.rstrip() + "\n" + "".join(HARNESS.format(function=name) for name in names)
    answers: list[Answer] = []
    seconds = 0.0
    try:
        program = programs.open(text.encode(), kit)
    except StudentFault:
        return None
    try:
        for check, inputs in cases:
            answers += program.call_many(check.function, inputs, faults=1)
            for taken in program.call_many(f"duree_mesuree_de_{check.function}", inputs, faults=1):
                if isinstance(taken, StudentFault) or not isinstance(taken.value, float):
                    return None
                seconds += taken.value
    except StudentFault:
        return None
    finally:
        program.close()
    if any(isinstance(answer, StudentFault) for answer in answers):
        return None
    return _MeasuredRun(answers, max(seconds, 1e-9))


def _are_same_answers(
    cases: Sequence[tuple[Cases, Sequence[Arguments]]], own: Sequence[Answer], others: Sequence[Answer]
) -> bool:
    checks = [check for check, inputs in cases for _ in inputs]
    return len(own) == len(others) == len(checks) and all(
        not isinstance(mine, StudentFault)
        and not isinstance(other, StudentFault)
        and compare(check.compare, mine.value, other.value) is None
        for check, mine, other in zip(checks, own, others, strict=True)
    )
