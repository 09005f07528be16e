"""A verdict for the terminal, whether it comes from here or from a server."""

import textwrap
from collections.abc import Iterator
from typing import Any

from graders.core.compare import words
from graders.core.compare.python_values import restore_numbers
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.headline import headline
from graders.core.contract.outcomes import Blame
from graders.core.contract.verdict import TEACHER, CheckResult, Counterexample, Diagnosis, Verdict
from server.client.program.report import format_number, replace_control_characters
from server.text.repeated_lines import fold_repeated_lines

WIDTH = 100
FULL_MARKS, NOT_FULL, CANNOT = 0, 1, 2

EXIT_STATUSES = {Blame.NOBODY: FULL_MARKS, Blame.STUDENT: NOT_FULL, Blame.OURS: CANNOT}


def exit_status_of_verdict(verdict: Verdict) -> int:
    return EXIT_STATUSES[verdict.outcome.blame]


def render_verdict(verdict: Verdict) -> str:
    """The whole verdict in French, ready to print."""
    return "\n".join(_verdict_lines(verdict))


def _verdict_lines(verdict: Verdict) -> Iterator[str]:
    if verdict.outcome.counts:
        mark = f"{format_number(verdict.points)}/{format_number(verdict.max_points)}"
        yield f"{verdict.exercise} : {mark} — {verdict.outcome.brief}"
        if (told := headline(verdict)) != verdict.outcome.wording():
            yield from wrap_paragraph(f"{told.title}. {told.sentence}", indent=2)
    else:
        yield f"{verdict.exercise} : la correction a échoué de notre côté ; rien n’est compté."
        yield "Vous pouvez renvoyer le fichier tel quel."
    for remark in verdict.remarks:
        yield from wrap_paragraph(f"Remarque : {remark}", indent=2)
    yield ""
    messages: set[str] = set()
    for check in verdict.checks:
        yield from _check_lines(check, messages)
    if verdict.diagnosis:
        yield from _diagnosis_lines(verdict.diagnosis)
    yield from _stdout_lines(verdict.stdout)
    yield f"Graine : {verdict.seed} (pour refaire cette correction : --seed {verdict.seed})"


def _check_lines(check: CheckResult, messages: set[str]) -> Iterator[str]:
    mark = "✓" if check.passed else "–" if check.neutral else "✗"
    yield f"  {mark} {check.title}  ({format_number(check.points)}/{format_number(check.max_points)})"
    if check.passed:
        if check.message:
            yield from wrap_paragraph(check.message)
        return
    if check.message in messages:  # a file that does not load fails every check for one reason
        return
    messages.add(check.message)
    yield from wrap_paragraph(check.message)
    if check.counterexample and not (check.neutral or check.repeats):
        yield from _counterexample_lines(check.counterexample)
    if check.hint:
        yield from wrap_paragraph(f"→ {check.hint}")


def _counterexample_lines(example: Counterexample) -> Iterator[str]:
    for name, value in example.inputs.items():
        yield from _value_lines(name, value)
    expected, got = example.expected, example.got
    if not (isinstance(expected, str) or isinstance(got, str)):
        expected, got = value_text_pair(restore_numbers(expected), restore_numbers(got))
    if example.has_expected:
        yield from _value_lines("attendu", expected)
    yield from _value_lines("obtenu", got)


def _value_lines(name: str, value: Any) -> Iterator[str]:
    yield from wrap_paragraph(f"{name} : {value if isinstance(value, str) else _format_compact(value)}", indent=10)


def _format_compact(value: Any) -> str:
    """French numbers, as in the messages; `--json` has all their digits."""
    return words.text(restore_numbers(value))


def _diagnosis_lines(diagnosis: Diagnosis) -> Iterator[str]:
    yield ""
    seen = " (vu par votre enseignant)" if diagnosis.source == TEACHER else ""
    yield f"Diagnostic : {diagnosis.title}{seen}"
    yield from wrap_paragraph(diagnosis.explanation, indent=2)
    yield ""


def _stdout_lines(text: str) -> Iterator[str]:
    if text.strip():
        yield "Affiché par le programme :"
        yield from (
            f"  │ {replace_control_characters(line)}" for line in fold_repeated_lines(text.rstrip("\n")).splitlines()
        )


def wrap_paragraph(text: str, indent: int = 6) -> Iterator[str]:
    margin = " " * indent
    for line in replace_control_characters(text).splitlines():
        yield from textwrap.wrap(line, WIDTH, initial_indent=margin, subsequent_indent=margin) or [""]
