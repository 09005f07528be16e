"""Comparison of what the solution and a student's program did in one case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from graders.core.compare.comparison import Mismatch
from graders.core.compare.python_values import RaisedException
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Value
from graders.core.declared.declaration import DeclaredCheck, DrawnCase
from graders.core.declared.playing import PlayedScenario, is_exception
from graders.core.declared.references import make_reference
from graders.core.declared.scenarios import Scenario


@dataclass(frozen=True)
class Case:
    """A case of a check; `drawn` where it may be simplified."""

    scenario: Scenario
    drawn: DrawnCase | None = None


@dataclass(frozen=True)
class FailedCase:
    """A failing case, with what the solution and the student's program did, and why they disagree."""

    case: Case
    right: PlayedScenario
    got: PlayedScenario
    mismatch: Mismatch | None
    step: int = 0


def judge(check: DeclaredCheck, case: Case, right: PlayedScenario, got: PlayedScenario) -> FailedCase | None:
    """Return why a program's answer to a case is not the reference (`make_reference`); None where they agree."""
    check, last = check.with_tolerance_of_case(case.scenario), len(case.scenario.statements) - 1
    if right.raised is not None:
        return _judge_exception(check, case, right, got)
    right = make_reference(check, case.scenario, right)
    if got.fault is not None:
        return FailedCase(case, right, got, None, last)
    if got.raised is not None:
        step = len(got.values) - 1
        raised = Mismatch(f"L’exception {got.raised} est levée.", cause=Outcome.RUNTIME_ERROR)
        return FailedCase(case, right, got, raised, step)
    return _judge_values(check, case, right, got)


def agrees_with_author(check: DeclaredCheck, expected: Value, given: Value) -> bool:
    """Whether what the solution gives is what the author expects."""
    if isinstance(expected, RaisedException):
        return isinstance(given, RaisedException) and is_exception(given, expected)
    if check.watched == "printed" and isinstance(expected, str) and isinstance(given, str):
        return _compare_printed(check, expected, given) is None
    return check.comparator(expected, given) is None


def _judge_exception(check: DeclaredCheck, case: Case, right: PlayedScenario, got: PlayedScenario) -> FailedCase | None:
    """Judge a scenario that the solution ends with an exception."""
    assert right.raised is not None
    if got.raised is not None and is_exception(got.raised, right.raised):
        return None
    if got.fault is not None and got.raised is None:
        return FailedCase(case, right, got, None, len(case.scenario.statements) - 1)
    step = (len(right.values) if right.fault is None else len(case.scenario.statements)) - 1
    if got.raised is None:  # no slip: what a value looks like says nothing of why nothing is raised
        return FailedCase(case, right, got, Mismatch("Aucune exception n’est levée."), step)
    return FailedCase(case, right, got, check.comparator(right.raised, got.raised) or Mismatch(""), step)


def _judge_values(check: DeclaredCheck, case: Case, right: PlayedScenario, got: PlayedScenario) -> FailedCase | None:
    """Judge a scenario that no exception ended."""
    last = len(case.scenario.statements) - 1
    if check.watched == "printed":
        if _compare_printed(check, right.screen, got.screen) is None:
            return None
        printed = _compare_printed(check, right.printed, got.printed)
        return FailedCase(case, right, got, printed, last) if printed else None
    if check.watched == "written":
        files = _compare_written_files(check, right.written, got.written)
        return FailedCase(case, right, got, files, last) if files else None
    for step, statement in enumerate(case.scenario.statements):
        wanted = _value_at_step(right, step)
        if not statement.is_shown or (wanted is None and step != last):
            continue
        mismatch = check.comparator(wanted, _value_at_step(got, step))
        if mismatch is not None:
            return FailedCase(case, right, got, mismatch, step)
    return None


def _compare_printed(check: DeclaredCheck, expected: str, got: str) -> Mismatch | None:
    """Compare what was printed; spaces at the end of lines and empty lines at the end never count."""
    if not got.strip() and expected.strip():
        return Mismatch("Rien n’est affiché : il manque sans doute un « print ».")
    return _compare_texts(check, expected, got)


def _compare_texts(check: DeclaredCheck, expected: str, got: str) -> Mismatch | None:
    wanted, obtained = ("\n".join(line.rstrip() for line in it.rstrip().split("\n")) for it in (expected, got))
    return check.comparator(wanted, obtained)


def _compare_written_files(
    check: DeclaredCheck, expected: Mapping[str, str], got: Mapping[str, str]
) -> Mismatch | None:
    """Compare the files that were written, each as what is printed."""
    missing = next((name for name in expected if name not in got), None)
    if missing is not None:
        return Mismatch(f"Le fichier « {missing} » n’est pas écrit.")
    mismatches = ((name, _compare_texts(check, text, got[name])) for name, text in expected.items())
    first = next(((name, found) for name, found in mismatches if found), None)
    return first and replace(first[1], words=f"Dans « {first[0]} » : {first[1].message}")


def _value_at_step(played: PlayedScenario, step: int) -> Value:
    return played.values[step] if step < len(played.values) else None


def observed_value(check: DeclaredCheck, played: PlayedScenario, step: int) -> Value:
    """Return what a check looks at in one step: an exception, what was printed, or a value."""
    if played.raised is not None:
        return played.raised
    if check.watched == "value":
        return _value_at_step(played, step)
    return played.printed if check.watched == "printed" else dict(played.written)


def gives_expected_value(check: DeclaredCheck, expected: Value, played: PlayedScenario, step: int) -> bool:
    """Whether a program gives what the author expects; of what is printed, with or without what is typed."""
    if agrees_with_author(check, expected, observed_value(check, played, step)):
        return True
    return check.watched == "printed" and played.raised is None and agrees_with_author(check, expected, played.screen)


def is_answered(right: PlayedScenario) -> bool:
    """Whether the solution answered: a value, or an exception of its own."""
    return right.fault is None or right.raised is not None


def fails_alike(first: FailedCase, other: FailedCase) -> bool:
    """Whether two failures are of one kind: the same exception, or wrong values of the same cause."""
    kinds = [
        (it.mismatch.slip, it.mismatch.cause) if it.mismatch else (it.got.fault and it.got.fault.exception, None)
        for it in (first, other)
    ]
    return kinds[0] == kinds[1]
