"""Python's notation read as data: a declaration's cases and draws are parsed, and never run here."""

from __future__ import annotations

import ast
from collections.abc import Collection

from graders.core.declared.malformed import MalformedDeclaration
from graders.core.syntax_trees import parse_source


def parse_python(text: str, *, described: str = "") -> ast.Module:
    """Return the syntax tree of a text. Raises MalformedDeclaration, which quotes it and calls it `described`."""
    try:
        return parse_source(text.strip())
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        detail = error.msg if isinstance(error, SyntaxError) else "texte illisible"
        raise MalformedDeclaration(f"« {text.strip()[:80]} »{described} : {detail}") from error


def refusal_error(node: ast.AST, reason: str) -> MalformedDeclaration:
    """Return the error of a part of a text."""
    return MalformedDeclaration(f"« {ast.unparse(node)[:80]} » : {reason}")


def unwrap_call(node: ast.expr, functions: Collection[str]) -> ast.expr:
    """Return the call of one of `functions` inside list(…) or tuple(…), which read what it gives; else the node.

    Raises MalformedDeclaration for such a call inside another function of Python.
    """
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name) or node.func.id in functions:
        return node
    inner = node.args[0] if len(node.args) == 1 and not node.keywords else None
    if not isinstance(inner, ast.Call) or not isinstance(inner.func, ast.Name) or inner.func.id not in functions:
        return node
    if node.func.id in ("list", "tuple"):
        return inner
    if node.func.id in ("sorted", "len", "sum", "set", "max", "min", "next", "str", "repr", "round"):
        asked = ", et choisissez « Ordre : il est libre » si l’ordre ne compte pas" if node.func.id == "sorted" else ""
        raise refusal_error(node, f"appelez votre fonction seule, {ast.unparse(inner)[:80]}{asked}")
    return node
