"""Alterations of statements: dropped statements, other conditions, other assignments."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from graders.core.alterations.calls import WRAP
from graders.core.alterations.expressions import called_name, is_normalisation
from graders.core.alterations.text import Change, ProgramText

AUGMENTED = {
    ast.Add: ("+=", ("-=", "=")),
    ast.Sub: ("-=", ("+=", "=")),
    ast.Mult: ("*=", ("/=", "=")),
    ast.Div: ("/=", ("*=", "=")),
    ast.Mod: ("%=", ("=",)),
    ast.BitAnd: ("&=", ("|=", "=")),
    ast.BitOr: ("|=", ("&=", "=")),
}


def drop_statements(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A statement left out, where the program still runs without it: not the first value that a name is given."""
    if isinstance(node, ast.Assign) and all(_is_assigned_before(text, node, target) for target in node.targets):
        value: ast.expr | None = node.value
    elif isinstance(node, ast.AugAssign | ast.Expr | ast.Assert):
        value = node.value if not isinstance(node, ast.Assert) else None
    elif isinstance(node, ast.Raise | ast.Break | ast.Continue):
        value = None
    else:
        return
    own = (value is not None and _holds_normalisation(value)) or (
        isinstance(node, ast.AugAssign) and is_normalisation(ast.BinOp(node.target, node.op, node.value))
    )
    yield text.replace_node(node, "pass", "normalisation oubliée" if own else "instruction oubliée", own=own)


def _is_assigned_before(text: ProgramText, node: ast.Assign, target: ast.expr) -> bool:
    """Does a target have a value already: a place in something, an argument, a name given before or in a loop?"""
    if isinstance(target, ast.Tuple | ast.List):
        return all(_is_underscore(bound) or _is_assigned_before(text, node, bound) for bound in target.elts)
    if not isinstance(target, ast.Name):
        return isinstance(target, ast.Subscript | ast.Attribute)
    around: ast.AST = node
    while around is not text.tree and not isinstance(around, ast.FunctionDef):
        around = text.parent(around)
    names = [bound for bound in ast.walk(around) if isinstance(bound, ast.Name | ast.arg) and _is_assigned_name(bound)]
    here = text.span(node)[0]
    return any(text.span(bound)[0] < here and _name_or_empty(bound) == target.id for bound in names)


def _is_underscore(target: ast.expr) -> bool:
    """Is this the name of what nobody reads, « _ » ?"""
    return isinstance(target, ast.Name) and target.id == "_"


def _is_assigned_name(node: ast.AST) -> bool:
    return isinstance(node, ast.arg) or (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store))


def _name_or_empty(node: ast.AST) -> str:
    return node.arg if isinstance(node, ast.arg) else node.id if isinstance(node, ast.Name) else ""


def _holds_normalisation(value: ast.expr) -> bool:
    return any(
        (isinstance(node, ast.BinOp) and is_normalisation(node))
        or (isinstance(node, ast.Call) and bool(WRAP.search(called_name(node))))
        for node in ast.walk(value)
    )


def alter_augmented_assignments(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """« -= » or « = » for « += », and so on."""
    if isinstance(node, ast.AugAssign) and type(node.op) in AUGMENTED:
        spelled, others = AUGMENTED[type(node.op)]
        start, end = text.operator_span(node.target, node.value, spelled)
        for other in others:
            yield Change(start, end, other, "affectation")


def alter_conditions(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A condition that always holds, never does, or is the contrary; a loop that is never entered."""
    tests: list[ast.expr] = []
    if isinstance(node, ast.If | ast.While):
        tests = [node.test]
    elif isinstance(node, ast.comprehension):
        tests = node.ifs
    for test in tests:
        yield text.replace_node(test, "False", "condition")
        if not isinstance(node, ast.While):
            yield text.replace_node(test, "True", "condition")
        if not isinstance(test, ast.Compare):
            yield text.replace_node(test, f"not ({text.source_of(test)})", "condition")


def exchange_break_and_continue(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """« break » for « continue », and the contrary."""
    if isinstance(node, ast.Break):
        yield text.replace_node(node, "continue", "saut")
    if isinstance(node, ast.Continue):
        yield text.replace_node(node, "break", "saut")


RULES = (drop_statements, alter_augmented_assignments, alter_conditions, exchange_break_and_continue)
