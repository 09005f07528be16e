"""All that there is to say of a program that passes, as candidates that are to be tried. Pure."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator

from graders.core.advice.edits import Advice
from graders.core.advice.loops import list_loop_advice, list_repeated_work
from graders.core.advice.style import list_copies, list_hiding_names, list_inverses
from graders.core.syntax_trees import parse_or_none

MAX_CANDIDATES = 12
MAX_SOURCE = 40_000


def list_advice(source: str, functions: Collection[str], reference: str) -> Iterator[Advice]:
    """Yield advice on a program: what gains time first. `functions` are those that the statement asks.

    An edit that fits the text may still change what the program does: whoever shows advice tries it first. What the
    `reference` does too is not held against a student.
    """
    if len(source) > MAX_SOURCE or "\f" in source or "\r" in source:
        return
    tree = parse_or_none(source)
    if tree is None:
        return
    found = 0
    for advice in _iter_all_advice(source, tree, functions, reference):
        if found == MAX_CANDIDATES:
            return
        if _imports_numpy_where_needed(advice, tree):
            found += 1
            yield advice


def _iter_all_advice(source: str, tree: ast.Module, functions: Collection[str], reference: str) -> Iterator[Advice]:
    yield from list_loop_advice(source, tree)
    yield from list_repeated_work(source, tree)
    if "linalg.inv" not in reference:
        yield from list_inverses(source, tree)
    yield from list_copies(source, tree)
    yield from list_hiding_names(source, tree, functions)


def _imports_numpy_where_needed(advice: Advice, tree: ast.Module) -> bool:
    """Whether `np` in the edited lines is numpy: every program finds it so, unless it calls another thing that."""
    if "np." not in advice.after or "np." in advice.before:
        return True
    stored = (node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store))
    return "np" not in set(stored)
