"""What a line computes, held against what the exercise's solution computes in the same calls.

A line whose values the solution computes too is right as it stands, whatever a change there mends: the change makes up
for a mistake of another line. One whose values are the solution's only when it is changed is the wrong one.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Sequence
from enum import Enum

from graders.core.alterations.text import ProgramText
from graders.core.code.changes import insert_with_loop_counters
from graders.core.code.variants import SEE

#: Numbers of a call in the form in which they are compared.
Seen = frozenset[tuple[float, ...]]


class LineEvidence(Enum):
    """What the values of a line say of it."""

    RIGHT, WRONG, UNKNOWN = "right", "wrong", "unknown"


def insert_line_recorder(source: str, line: int) -> str | None:
    """Return a program that shows what the statement of a line sets or returns; None where no simple one is there."""
    text = ProgramText.parse_or_none(source)
    statements = _iter_assignments_and_returns(text) if text is not None else ()
    found = [node for node in statements if node.lineno <= line <= (node.end_lineno or 0)]
    return None if text is None or not found else _insert_value_recorders(text, found[-1:])


def insert_all_recorders(source: str) -> str | None:
    """Return a program that shows what each of its statements sets or returns."""
    text = ProgramText.parse_or_none(source)
    return None if text is None else _insert_value_recorders(text, list(_iter_assignments_and_returns(text)))


def judge_line_by_values(
    before: Sequence[Iterable[Sequence[float]]],
    after: Sequence[Iterable[Sequence[float]]],
    solution: Sequence[Iterable[Sequence[float]]],
) -> LineEvidence:
    """Compare the values of a line in some calls, before and after a change, with all values of the solution.

    Those that the change leaves say nothing, nor do counts and indices, which are everywhere; the solution may leave
    out some that it need not compute.
    """
    rows = [
        (mine - changed, changed - mine, right)
        for mine, changed, right in zip(
            map(_round_rich_values, before),
            map(_round_rich_values, after),
            map(_round_rich_values, solution),
            strict=False,
        )
    ]
    telling = [(bool(lost & right), bool(gained & right)) for lost, gained, right in rows if lost | gained]
    if telling and all(was and not becomes for was, becomes in telling):
        return LineEvidence.RIGHT
    if telling and all(becomes and not was for was, becomes in telling):
        return LineEvidence.WRONG
    return LineEvidence.UNKNOWN


def _iter_assignments_and_returns(text: ProgramText) -> Iterator[ast.Assign | ast.AugAssign | ast.Return]:
    for node in ast.walk(text.tree):
        if isinstance(node, ast.Assign | ast.AugAssign) or (isinstance(node, ast.Return) and node.value is not None):
            yield node


def _insert_value_recorders(text: ProgramText, statements: Iterable[ast.Assign | ast.AugAssign | ast.Return]) -> str:
    added: list[tuple[int, bytes]] = []
    for statement in statements:
        if isinstance(statement, ast.Return):
            assert statement.value is not None
            start, end = text.span(statement.value)
            added += [(start, f"{SEE}(".encode()), (end, b")")]
        else:
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            shown = "".join(f"; {SEE}({text.source_of(target)})" for target in targets)
            added.append((text.span(statement)[1], shown.encode()))
    return insert_with_loop_counters(text, added)


def _round_rich_values(values: Iterable[Sequence[float]]) -> Seen:
    return frozenset(tuple(float(f"{number:.7g}") + 0.0 for number in row) for row in values if _has_fraction(row))


def _has_fraction(value: Sequence[float]) -> bool:
    return any(number != round(number) for number in value if abs(number) < float("inf"))
