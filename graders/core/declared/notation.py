"""Python's notation read as data: a declaration's cases and draws are parsed, and never run here."""

from __future__ import annotations

import ast

from graders.core.declared.malformed import MalformedDeclaration
from graders.core.syntax_trees import parse_source


def parse_python(text: str, *, described: str = "") -> ast.Module:
    """Return the syntax tree of a text. Raises MalformedDeclaration, which quotes it and calls it `described`."""
    try:
        return parse_source(text.strip())
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        detail = error.msg if isinstance(error, SyntaxError) else "texte illisible"
        raise MalformedDeclaration(f"« {text.strip()[:80]} »{described} : {detail}") from error


def refusal(node: ast.AST, reason: str) -> MalformedDeclaration:
    """Return the error of a part of a text."""
    return MalformedDeclaration(f"« {ast.unparse(node)[:80]} » : {reason}")
