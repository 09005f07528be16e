"""A program that the course knows, as a student would have written it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence

from graders.core.syntax_trees import parse_source

FOR_LINTER = re.compile(r"[ \t]*# noqa\b.*")
DEFINITIONS = (ast.FunctionDef, ast.ClassDef)


def format_as_student_file(source: bytes, repeats: int) -> bytes:
    """Return a program of the course in the form of a student's file.

    A mistake of the catalogue may be the solution followed by wrong functions: each function stays once, and the words
    that its author put at the top of a specimen, or for a linter, are left out. A program that was sent `repeats` times
    before prints a mark, as students do who look for their mistake.
    """
    mark = f'print("ici{f" {repeats}" if repeats > 1 else ""}")'
    try:
        source = FOR_LINTER.sub("", source.decode()).encode()
        lines = _remove_docstring_and_redefined_functions(source.decode().split("\n"), parse_source(source).body)
        lines = _insert_line_before_last_return(lines, mark) if repeats else lines
    except (SyntaxError, ValueError):
        return source + f"\n{mark}\n".encode() if repeats else source
    return "\n".join(lines).encode()


def _remove_docstring_and_redefined_functions(lines: Sequence[str], body: Sequence[ast.stmt]) -> list[str]:
    """Leave out the text at the top, and functions that are defined again later unless used meanwhile."""
    left_out = {place for statement in _find_docstring_and_redefinitions(body) for place in _line_indices(statement)}
    kept = [line for number, line in enumerate(lines) if number not in left_out]
    return _collapse_blank_lines(kept) if left_out else list(lines)


def _find_docstring_and_redefinitions(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    latest = {statement.name: statement for statement in body if isinstance(statement, DEFINITIONS)}
    used = {
        node.id
        for statement in body
        if not isinstance(statement, DEFINITIONS)
        for node in ast.walk(statement)
        if isinstance(node, ast.Name)
    }
    for number, statement in enumerate(body):
        if isinstance(statement, DEFINITIONS):
            if latest[statement.name] is not statement and statement.name not in used:
                yield statement
        elif number == 0 and _is_docstring(statement):
            yield statement


def _is_docstring(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(getattr(statement.value, "value", None), str)


def _line_indices(statement: ast.stmt) -> range:
    """Return the places of its lines, from 0, decorators included."""
    decorators = getattr(statement, "decorator_list", [])
    first = min(node.lineno for node in (statement, *decorators))
    return range(first - 1, statement.end_lineno or first)


def _collapse_blank_lines(lines: Sequence[str]) -> list[str]:
    """Leave at most two empty lines together, and none at the top."""
    shown: list[str] = []
    for line in lines:
        if line.strip() or (shown and any(before.strip() for before in shown[-2:])):
            shown.append(line)
    return shown


def _insert_line_before_last_return(lines: Sequence[str], inserted_line: str) -> list[str]:
    """Add a line before the last `return` that stands alone on its lines; at the end where there is none.

    Raise SyntaxError as `parse_source` does.
    """
    places = [
        node.lineno - 1
        for node in ast.walk(parse_source("\n".join(lines)))
        if isinstance(node, ast.Return) and lines[node.lineno - 1].lstrip().startswith("return")
    ]
    if not places:
        return [*lines, inserted_line, ""]
    place = max(places)
    line = lines[place]
    return [*lines[:place], line[: len(line) - len(line.lstrip())] + inserted_line, *lines[place:]]
