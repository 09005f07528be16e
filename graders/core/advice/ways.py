"""Other right ways of writing a program: of the course's specimens, those that differ most. Pure."""

from __future__ import annotations

import ast
import io
import math
import tokenize
from collections import Counter
from collections.abc import Mapping, Sequence

from graders.core.syntax_trees import parse_source

MAX_LINES = 60


def choose_diverse_specimens(reference: str, specimens: Mapping[str, str], count: int = 2) -> Sequence[str]:
    """Return the names of the specimens that differ most from the reference and from one another.

    Programs differ by the kinds of nodes of their syntax trees; long ones are left out.
    """
    profiles = {
        name: _count_node_types(text) for name, text in sorted(specimens.items()) if text.count("\n") <= MAX_LINES
    }
    chosen: list[str] = []
    seen = [_count_node_types(reference)]
    while len(chosen) < count and len(chosen) < len(profiles):
        left = [name for name in profiles if name not in chosen]
        best = max(left, key=lambda name: min(_cosine_distance(profiles[name], other) for other in seen))
        chosen.append(best)
        seen.append(profiles[best])
    return chosen


def _count_node_types(source: str) -> Counter[str]:
    return Counter(type(node).__name__ for node in ast.walk(parse_source(source)))


def _cosine_distance(first: Counter[str], second: Counter[str]) -> float:
    """Return one minus the cosine of the angle between two profiles."""
    product = sum(first[name] * second[name] for name in first.keys() & second.keys())
    norms = math.sqrt(sum(n * n for n in first.values()) * sum(n * n for n in second.values()))
    return 1.0 - product / norms if norms else 1.0


def strip_docstrings_and_comments(source: str) -> str:
    """Return a program without its docstrings and comments, which are for the course's authors."""
    source = source.removeprefix("\ufeff")
    lines: list[str] = []
    removed = _docstring_lines(parse_source(source))
    columns = _comment_columns(source)
    for number, line in enumerate(source.splitlines(), 1):
        code = line[: columns[number]].rstrip() if number in columns else line
        if number not in removed and (code.strip() or number not in columns):
            lines.append(code)
    return "\n".join(lines).strip("\n") + "\n"


def _docstring_lines(tree: ast.Module) -> set[int]:
    """Return the numbers of the lines of docstrings, but for those that are all of a body."""
    removed: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef) and len(node.body) > 1:
            first = node.body[0]
            if ast.get_docstring(node, clean=False) is not None:
                removed |= set(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    return removed


def _comment_columns(source: str) -> dict[int, int]:
    """Return the column at which the comment of each line with one begins."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return {token.start[0]: token.start[1] for token in tokens if token.type == tokenize.COMMENT}
