"""The alterations of a program: every way in which the rules change it at one place."""

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
    """A program changed at one place: `altered`, in `function` ("" outside of all), from its line `line` on.

    `own` says that its operator is the course's own: a mistake that it warns of, and which no check may let pass.
    """

    source: str
    altered: str
    operator: str
    is_course_mistake: bool
    line: int
    function: str

    @cached_property
    def removed(self) -> tuple[str, ...]:
        """The lines that are no longer there, without their margins."""
        return self._lines("-")

    @cached_property
    def added(self) -> tuple[str, ...]:
        """The lines that stand there instead, without their margins."""
        return self._lines("+")

    def _lines(self, sign: str) -> tuple[str, ...]:
        return tuple(line[1:].strip() for line in self.diff(context=0) if line.startswith(sign))

    def diff(self, context: int = 1) -> Iterator[str]:
        """The unified diff, without the names of its files."""
        lines = difflib.unified_diff(self.source.splitlines(), self.altered.splitlines(), n=context, lineterm="")
        yield from list(lines)[2:]


def find_alterations(source: str) -> list[Alteration]:
    """Every alteration of a program that still compiles and is another program, in the order of its lines.

    Raises SyntaxError for what is no program.
    """
    text = ProgramText(source)
    changes = [
        (change, text.function(node), getattr(node, "lineno", 1))
        for node in text.nodes()
        for rule in RULES
        for change in rule(text, node)
    ]
    changes.sort(key=lambda found: (found[0].start, found[0].end, not found[0].is_course_mistake, found[0].text))
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
    """Is it a program, and another one?"""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            tree = ast.parse(altered)
            compile(tree, "solution.py", "exec")
    except (SyntaxError, ValueError):
        return False
    return ast.dump(tree) != same
