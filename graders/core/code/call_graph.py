"""Which functions of a program call which: a wrong answer of one may come from another."""

from __future__ import annotations

import ast
from collections.abc import Collection

from graders.core.syntax_trees import parse_source


def find_callers(source: bytes, names: Collection[str]) -> frozenset[str]:
    """Return the functions of a program that call one of these, by others or not; none where it cannot be read."""
    try:
        tree = parse_source(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return frozenset()
    read = {
        node.name: {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
        for node in tree.body
        if isinstance(node, ast.FunctionDef)
    }
    found = set(names)
    while more := {name for name, used in read.items() if used & found} - found:
        found |= more
    return frozenset(found.difference(names))
