"""Mutation operators on a student's language: every change of a program at one location by the rules."""

from __future__ import annotations

import ast
import difflib
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from graders.core.alterations import calls, expressions, statements
from graders.core.alterations.text import ProgramText

RULES = (*expressions.RULES, *calls.RULES, *statements.RULES)


@dataclass(frozen=True)
class Alteration:
    """A program changed at one location: `altered`, in `function` ("" at the top level), from `line` on.

    `is_course_mistake` says that the operator is a mistake of which the course warns, and which every check must catch.
    """

    source: str
    altered: str
    operator: str
    is_course_mistake: bool
    line: int
    function: str

    @cached_property
    def removed(self) -> tuple[str, ...]:
        """The removed lines, without indentation."""
        return self._lines("-")

    @cached_property
    def added(self) -> tuple[str, ...]:
        """The added lines, without indentation."""
        return self._lines("+")

    def _lines(self, sign: str) -> tuple[str, ...]:
        return tuple(line[1:].strip() for line in self.diff(context=0) if line.startswith(sign))

    def diff(self, context: int = 1) -> Iterator[str]:
        """Yield the unified diff, without file names."""
        lines = difflib.unified_diff(self.source.splitlines(), self.altered.splitlines(), n=context, lineterm="")
        yield from list(lines)[2:]


def find_alterations(source: str) -> list[Alteration]:
    """Return every alteration that compiles and changes the syntax tree, in the order of the lines.

    Raises SyntaxError for an invalid source.
    """
    text = ProgramText(source)
    changes = [
        (change, text.function(node), getattr(node, "lineno", 1))
        for node in text.nodes()
        for rule in RULES
        for change in rule(text, node)
    ]
    changes.sort(key=lambda entry: (entry[0].start, entry[0].end, not entry[0].is_course_mistake, entry[0].text))
    alterations_by_text: dict[str, Alteration] = {}
    same = ast.dump(text.tree)
    for change, function, _ in changes:
        altered = text.apply(change)
        line = text.raw.count(b"\n", 0, change.start) + 1
        if altered not in alterations_by_text and _differs(altered, same):
            alterations_by_text[altered] = Alteration(
                source, altered, change.operator, change.is_course_mistake, line, function
            )
    return list(alterations_by_text.values())


def _differs(altered: str, same: str) -> bool:
    """Whether a source compiles and has another syntax tree."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            tree = ast.parse(altered)
            compile(tree, "solution.py", "exec")
    except (SyntaxError, ValueError):
        return False
    return ast.dump(tree) != same
