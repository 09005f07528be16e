"""Lines that have to do with one whose change mends a program, where its values do not show that it is the wrong one.

A change makes up for the mistake of another line often enough: of one that computes what the line reads, of one that
uses what a loop counts, or of a call where the line is in a function that a right one calls too. These are named, and
no more is said of them than what the program's text shows.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from graders.core.code.call_graph import find_callers
from graders.core.compare.forms import join_with_and
from graders.core.syntax_trees import parse_or_none

#: Names that a line reads that are told; lines where one name is read.
MAX_NAMES, MAX_USES = 3, 3
#: What a block of statements is read by: its header, without the block.
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")


@dataclass(frozen=True)
class JudgedFunctions:
    """The functions of an exercise that fail by themselves, and those that are right by themselves."""

    guilty: Collection[str] = ()
    right: Collection[str] = ()


NOT_JUDGED = JudgedFunctions()


def related_lines_sentence(
    source: str, lines: Sequence[int], functions: JudgedFunctions = NOT_JUDGED, is_borne_out: bool = False
) -> str:
    """Return a French sentence on the lines that these have to do with; empty where there are none.

    Of lines in a function that a right one calls too, the calls in those that fail are told; nothing else of lines
    whose values show that they are the wrong ones.
    """
    tree = parse_or_none(source)
    if tree is None:
        return ""
    around = _function_around(tree, lines[0])
    if around is not None and (told := _helper_calls_sentence(tree, source, around, functions)):
        return told
    if is_borne_out:
        return ""
    scope: ast.AST = tree if around is None else around
    statements = [node for line in lines for node in _iter_innermost_statements(scope, line)]
    reads = _last_computed_text(tree, scope, statements, lines)
    uses = _counter_uses_text(scope, statements)
    verb = "Elles lisent" if len(lines) > 1 else "Elle lit"
    return " ".join(part for part in (f"{verb} {reads}." if reads else "", f"{uses}." if uses else "") if part)


def _helper_calls_sentence(tree: ast.Module, source: str, helper: ast.FunctionDef, functions: JudgedFunctions) -> str:
    """The calls of a helper in the functions that fail, where a right one calls it too."""
    if helper.name in (*functions.guilty, *functions.right):
        return ""
    callers = find_callers(source.encode(), [helper.name])
    right = sorted(callers.intersection(functions.right))
    guilty = sorted(callers.intersection(functions.guilty))
    if not right or not guilty:
        return ""
    lines = sorted(
        {
            part.lineno
            for node in tree.body
            if isinstance(node, ast.FunctionDef) and node.name in guilty
            for part in ast.walk(node)
            if isinstance(part, ast.Name) and part.id == helper.name
        }
    )
    if not lines or len(lines) > MAX_USES:
        return ""
    verb = "n’ont" if len(right) > 1 else "n’a"
    where = f"ce que {' et '.join(guilty)} en {'font' if len(guilty) > 1 else 'fait'}, {_line_numbers_text(lines)}"
    return f"Mais {helper.name} sert aussi à {' et '.join(right)}, qui {verb} rien de faux : regardez plutôt {where}."


def _last_computed_text(
    tree: ast.Module, scope: ast.AST, statements: Sequence[ast.stmt], lines: Collection[int]
) -> str:
    """« loop (ligne 39) et norms (ligne 44) »: where what some statements read is last computed before them."""
    told: dict[str, int] = {}
    for statement in statements:
        for name in _names_in_context(statement, ast.Load):
            inside = [line for line in _lines_that_set(scope, name) if line < statement.lineno]
            above = inside or ([] if _is_parameter(scope, name) else _lines_that_set(tree, name, own_only=True))
            if above and above[-1] not in lines:
                told.setdefault(name, above[-1])
    where = [f"{name} (ligne {line})" for name, line in list(told.items())[:MAX_NAMES]]
    return join_with_and(where) if where else ""


def _counter_uses_text(scope: ast.AST, statements: Sequence[ast.stmt]) -> str:
    """« di sert aux lignes 15 et 17 »: where what loops count is read."""
    counted: list[str] = []
    found = set[int]()
    for statement in statements:
        for name in _names_in_context(statement, ast.Store) if isinstance(statement, ast.For) else ():
            inner = (node for part in ast.iter_child_nodes(statement) for node in ast.walk(part))
            read = (node for node in inner if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load))
            if uses := {node.lineno for node in read if node.id == name} - {statement.lineno}:
                counted.append(name)
                found |= uses
    if not found or len(found) > MAX_USES:
        return ""
    return (
        f"{join_with_and(counted)} {'servent' if len(counted) > 1 else 'sert'} {_line_numbers_text(sorted(found), 'à')}"
    )


def _function_around(tree: ast.Module, line: int) -> ast.FunctionDef | None:
    return next(
        (it for it in tree.body if isinstance(it, ast.FunctionDef) and it.lineno <= line <= _last_line(it)), None
    )


def _last_line(node: ast.stmt) -> int:
    return node.end_lineno or node.lineno


def _iter_innermost_statements(scope: ast.AST, line: int) -> Iterator[ast.stmt]:
    """Yield the innermost statement whose own text, without its blocks, holds a line."""
    found = [node for node in ast.walk(scope) if isinstance(node, ast.stmt) and node.lineno <= line <= _last_line(node)]
    yield from found[-1:]


def _names_in_context(statement: ast.stmt, context: type[ast.expr_context]) -> list[str]:
    """Return the names that a statement reads or sets itself, without its blocks, in the order of the text."""
    heads = [
        node
        for field, value in ast.iter_fields(statement)
        if field not in _BLOCKS
        for node in (value if isinstance(value, list) else [value])
        if isinstance(node, ast.AST)
    ]
    names = [part for head in heads for part in ast.walk(head) if isinstance(part, ast.Name)]
    names.sort(key=lambda name: (name.lineno, name.col_offset))
    return list(dict.fromkeys(name.id for name in names if isinstance(name.ctx, context)))


def _lines_that_set(scope: ast.AST, name: str, own_only: bool = False) -> list[int]:
    """Return the lines on which a statement sets a name, in order; `own_only`: those of the scope's own level."""
    nodes = scope.body if own_only and isinstance(scope, ast.Module) else ast.walk(scope)
    found = []
    for node in nodes:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AugAssign | ast.AnnAssign | ast.For) else targets
        if isinstance(node, ast.stmt) and any(name in _iter_target_names(target) for target in targets):
            found.append(node.lineno)
    return sorted(found)


def _iter_target_names(node: ast.expr) -> Iterator[str]:
    """Yield the names that a target sets, or of which it sets a part."""
    if isinstance(node, ast.Name):
        yield node.id
    elif isinstance(node, ast.Tuple | ast.List):
        for part in node.elts:
            yield from _iter_target_names(part)
    elif isinstance(node, ast.Subscript | ast.Starred):
        yield from _iter_target_names(node.value)


def _is_parameter(scope: ast.AST, name: str) -> bool:
    if not isinstance(scope, ast.FunctionDef):
        return False
    return name in {each.arg for each in ast.walk(scope.args) if isinstance(each, ast.arg)}


def _line_numbers_text(lines: Sequence[int], preposition: str = "") -> str:
    """« ligne 36 », « lignes 36 et 38 »; « à la ligne 36 », « aux lignes 36 et 38 »."""
    noun = "lignes" if len(lines) > 1 else "ligne"
    article = {"": "", "à": "aux " if len(lines) > 1 else "à la "}[preposition]
    return f"{article}{noun} {join_with_and([str(line) for line in lines])}"
