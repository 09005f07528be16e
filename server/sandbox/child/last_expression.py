"""Notebook cells: the last expression of a file prints its value."""

from __future__ import annotations

import ast
from types import CodeType

#: Maximum length of a printed value.
MAX_CHARACTERS = 4000


def split_last_expression(source: bytes, filename: str) -> list[CodeType]:
    """Compile the file in two parts: up to its last expression, then that expression, for `sys.displayhook`."""
    tree = ast.parse(source, filename)
    last = [tree.body.pop()] if tree.body and isinstance(tree.body[-1], ast.Expr) else []
    code = compile(tree, filename, "exec", dont_inherit=True)
    return [
        code,
        *(compile(ast.Interactive([expression]), filename, "single", dont_inherit=True) for expression in last),
    ]


def print_value(value: object) -> None:
    """Print the representation of a value; nothing for None, nor for matplotlib objects: the figure shows them."""
    if value is not None and not _is_drawing(value):
        text = repr(value)
        print(text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}…")


def _is_drawing(value: object) -> bool:
    items = value if isinstance(value, list | tuple) else (value,)
    return any(type(item).__module__.partition(".")[0] == "matplotlib" for item in items)
