"""What a notebook's cell does more than a file: its last expression shows its value."""

from __future__ import annotations

import ast
from types import CodeType

#: Characters of a value that are shown.
MAX_CHARACTERS = 4000


def split_last_expression(source: bytes, filename: str) -> list[CodeType]:
    """The file as it is run: up to its last expression, then that one alone, which `sys.displayhook` is told of."""
    tree = ast.parse(source, filename)
    last = [tree.body.pop()] if tree.body and isinstance(tree.body[-1], ast.Expr) else []
    code = compile(tree, filename, "exec", dont_inherit=True)
    return [code, *(compile(ast.Interactive([one]), filename, "single", dont_inherit=True) for one in last)]


def print_value(value: object) -> None:
    """Prints a value as Python writes it; nothing for None, nor for what drawing returns: the figure shows it."""
    if value is not None and not _is_drawing(value):
        text = repr(value)
        print(text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}…")


def _is_drawing(value: object) -> bool:
    inside = value if isinstance(value, list | tuple) else (value,)
    return any(type(one).__module__.partition(".")[0] == "matplotlib" for one in inside)
