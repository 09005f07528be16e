"""Reads Python source into a syntax tree, in one thread at a time.

CPython before 3.13 counts the depth of the tree that it builds for the whole interpreter: where a collection of garbage
lets another thread build one meanwhile, `ast.parse` ends in `SystemError: AST constructor recursion depth mismatch`
(python/cpython#106905). All of `graders` and `server` reads source here; ruff refuses `ast.parse` elsewhere.
"""

from __future__ import annotations

import ast
from threading import RLock
from typing import Any

_lock = RLock()  # a finalizer that runs while a tree is built may read source too


def parse_source(source: str | bytes) -> ast.Module:
    """Return the tree of a file; raise as `ast.parse` does: SyntaxError, ValueError, RecursionError or MemoryError."""
    with _lock:
        return ast.parse(source)  # noqa: TID251 - here alone


def parse_or_none(source: str | bytes) -> ast.Module | None:
    """Return the tree of a file; None where it cannot be read."""
    try:
        return parse_source(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def parse_expression(source: str) -> ast.Expression:
    """Return the tree of an expression; raise as `parse_source` does."""
    with _lock:
        return ast.parse(source, mode="eval")  # noqa: TID251 - here alone


def evaluate_literal(source: str) -> Any:
    """Return the value of a literal, as `ast.literal_eval` does with a text; raise as it does."""
    return ast.literal_eval(parse_expression(source.lstrip(" \t")))
