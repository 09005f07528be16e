"""Changes of a program that take the other end of a list: the usual mistake of a stack or of a queue."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from graders.core.alterations.alterations import Alteration
from graders.core.alterations.text import ProgramText

OPERATOR = "bout de la liste"


def swap_list_ends(source: str) -> list[Alteration]:
    """Return the program changed at one location each. Raises SyntaxError for an invalid source."""
    text = ProgramText(source)
    changes = [(node, other) for node in text.nodes() for other in _other_end(text, node)]
    changes.sort(key=lambda change: text.span(change[0]))
    altered = ((node, text.apply(text.replaced(node, other, OPERATOR))) for node, other in changes)
    return [Alteration(source, made, OPERATOR, False, _line(node), text.function(node)) for node, made in altered]


def _line(node: ast.AST) -> int:
    return int(node.lineno)  # type: ignore[attr-defined]


def _other_end(text: ProgramText, node: ast.AST) -> Iterator[str]:
    """Yield what a call or an index is with the other end of its list."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and not node.keywords:
        owner, method = text.source_of(node.func.value), node.func.attr
        if method == "pop" and not node.args:
            yield f"{owner}.pop(0)"
        elif method == "pop" and _is_number(node.args[0], 0):
            yield f"{owner}.pop()"
        elif method == "append" and len(node.args) == 1:
            yield f"{owner}.insert(0, {text.source_of(node.args[0])})"
    elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        ends = {0: "-1", -1: "0"}
        other = next((word for end, word in ends.items() if _is_number(node.slice, end)), "")
        if other:
            yield f"{text.source_of(node.value)}[{other}]"


def _is_number(node: ast.AST, number: int) -> bool:
    return isinstance(node, ast.Constant | ast.UnaryOp) and ast.unparse(node) == str(number)
