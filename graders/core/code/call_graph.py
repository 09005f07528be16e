"""Which functions of a program call which: a wrong answer of one may come from another."""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping, Set

from graders.core.syntax_trees import parse_or_none


def find_callers(source: bytes, names: Collection[str]) -> frozenset[str]:
    """Return the functions of a program that call one of these, by others or not; none where it cannot be read."""
    return _transitive_callers(_names_read_by_function(source), names)


def find_shared_helpers(source: bytes, functions: Collection[str], requested: Collection[str]) -> list[str]:
    """Return the functions of a program, none `requested` by the exercise, that several of these functions call."""
    read = _names_read_by_function(source)
    helpers = [name for name in read if name not in requested]
    return [name for name in helpers if len(_transitive_callers(read, [name]).intersection(functions)) > 1]


def _names_read_by_function(source: bytes) -> Mapping[str, Set[str]]:
    """Return the names that each function of a program reads; none where it cannot be read."""
    tree = parse_or_none(source)
    if tree is None:
        return {}
    return {
        node.name: {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
        for node in tree.body
        if isinstance(node, ast.FunctionDef)
    }


def _transitive_callers(read: Mapping[str, Set[str]], names: Collection[str]) -> frozenset[str]:
    found = set(names)
    while more := {name for name, used in read.items() if used & found} - found:
        found |= more
    return frozenset(found.difference(names))
