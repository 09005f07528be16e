"""Changes of a class whose methods forget one another: one answers as if another had never been called."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator

from graders.core.alterations.text import Change, ProgramText

STALE = "effet ignoré"


def iter_forgetful_changes(text: ProgramText, node: ast.ClassDef) -> Iterator[tuple[Change, ast.FunctionDef, str]]:
    """Yield a class in which one method answers from the state before the last call of another, which changes it.

    With each change, the method that answers, and words: « `est_vide` ne tient pas compte de `depiler` ».
    """
    methods = [each for each in node.body if isinstance(each, ast.FunctionDef) and not each.name.startswith("_")]
    called = [each for each in methods if each.args.args and not each.decorator_list]
    for changing, answering in itertools.permutations(called, 2):
        if _changes_state(changing) and _returns_value(answering):
            ours, theirs = changing.args.args[0].arg, answering.args.args[0].arg
            saved = _insertion_before_body(text, changing, f"import copy; {ours}._avant = copy.deepcopy({ours})")
            used = _insertion_before_body(text, answering, f"{theirs} = getattr({theirs}, '_avant', {theirs})")
            first, second = sorted((saved, used))
            between = text.slice(first[0], second[0])
            change = Change(first[0], second[0], f"{first[1]}{between}{second[1]}", STALE)
            yield change, answering, f"`{answering.name}` ne tient pas compte de `{changing.name}`"


def _returns_value(method: ast.FunctionDef) -> bool:
    return any(isinstance(part, ast.Return) and part.value is not None for part in ast.walk(method))


def _changes_state(method: ast.FunctionDef) -> bool:
    """Whether a method stores in its object, or calls a method of what the object holds."""
    name = method.args.args[0].arg
    return any(_changes_named_object(part, name) for part in ast.walk(method))


def _changes_named_object(part: ast.AST, name: str) -> bool:
    if isinstance(part, ast.Call) and isinstance(part.func, ast.Attribute):
        return isinstance(part.func.value, ast.Attribute) and _root_name(part.func.value) == name
    is_stored = isinstance(part, ast.Attribute | ast.Subscript) and isinstance(part.ctx, ast.Store | ast.Del)
    return is_stored and _root_name(part) == name


def _root_name(node: ast.AST) -> str:
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


def _insertion_before_body(text: ProgramText, method: ast.FunctionDef, statement: str) -> tuple[int, str]:
    change = insert_first(text, method, statement, STALE)
    return change.start, change.text


def insert_first(text: ProgramText, node: ast.FunctionDef, statement: str, operator: str) -> Change:
    """Return the change that puts a statement before the others of a function."""
    has_docstring = len(node.body) > 1 and ast.get_docstring(node, clean=False) is not None
    start = text.span(node.body[1] if has_docstring else node.body[0])[0]
    indent = text.slice(text.raw.rfind(b"\n", 0, start) + 1, start)
    between = "; " if indent.strip() else f"\n{indent}"
    return Change(start, start, f"{statement}{between}", operator)
