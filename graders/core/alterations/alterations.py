"""Mutation operators on a student's language: every change of a program at one location by the rules."""

from __future__ import annotations

import ast
import difflib
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial

from graders.core.alterations import calls, expressions, statements
from graders.core.alterations.text import Change, ProgramText
from graders.core.syntax_trees import parse_source

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
    def removed_lines(self) -> tuple[str, ...]:
        """The removed lines, without indentation."""
        return self._diff_lines("-")

    @cached_property
    def added_lines(self) -> tuple[str, ...]:
        """The added lines, without indentation."""
        return self._diff_lines("+")

    def _diff_lines(self, sign: str) -> tuple[str, ...]:
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
    alterations_by_text: dict[str, Alteration] = {}
    for alteration in map(partial(_apply_change, source, text, ast.dump(text.tree)), _find_changes(text)):
        if alteration is not None:
            alterations_by_text.setdefault(alteration.altered, alteration)
    return list(alterations_by_text.values())


def sample_alterations(source: str, most: int) -> list[Alteration]:
    """Return at most so many alterations, spread evenly over the program: the same ones each time.

    Each takes the time of a compilation, so that a long program takes no longer than its length. Raises SyntaxError.
    """
    text = ProgramText(source)
    changes = _find_changes(text)
    same, chosen = ast.dump(text.tree), dict[str, Alteration]()
    step = max(1.0, len(changes) / most)
    for rank in range(min(most, len(changes))):
        alteration = _apply_change(source, text, same, changes[int(rank * step)])
        if alteration is not None:
            chosen.setdefault(alteration.altered, alteration)
    return list(chosen.values())


def _find_changes(text: ProgramText) -> list[tuple[Change, str]]:
    """Return every change by the rules with the function around it, in the order of the lines."""
    changes = [
        (change, text.enclosing_function_name(node))
        for node in text.iter_alterable_nodes()
        for rule in RULES
        for change in rule(text, node)
    ]
    changes.sort(key=lambda entry: (entry[0].start, entry[0].end, not entry[0].is_course_mistake, entry[0].text))
    return changes


def _apply_change(source: str, text: ProgramText, same: str, entry: tuple[Change, str]) -> Alteration | None:
    """Return the alteration of a source by a change; None where it does not compile, or leaves the tree `same`."""
    change, function = entry
    altered = text.apply(change)
    if not _is_different_program(altered, same):
        return None
    line = text.raw.count(b"\n", 0, change.start) + 1
    return Alteration(source, altered, change.operator, change.is_course_mistake, line, function)


def _is_different_program(altered: str, same: str) -> bool:
    """Whether a source compiles and has another syntax tree."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)
            tree = parse_source(altered)
            compile(tree, "solution.py", "exec")
    except (SyntaxError, ValueError):
        return False
    return ast.dump(tree) != same
