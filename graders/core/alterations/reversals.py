"""Further changes of a student's program that may mend it: what mistakes do, undone.

The rules of the other modules make mistakes of right programs, and many of them are their own reversal. These add what
is missing in a wrong program: a copy, a type, an axis, an order, a square root, another variable.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator

from graders.core.alterations.calls import split_words
from graders.core.alterations.expressions import called_name
from graders.core.alterations.text import Change, ProgramText

#: Functions that make arrays, and may be asked for whole or short numbers.
_MAKERS = split_words("array zeros ones full empty zeros_like ones_like full_like asarray arange")
#: Functions that reduce an array along an axis.
_REDUCERS = split_words(
    "sum mean max min argmin argmax median prod cumsum any all std var norm argsort sort amin amax unique"
)
_SHORT_TYPES = split_words("int int32 int64 float32 float16 single half bool i i4 i8 f4 f2")
#: Simple statements that may change places.
_SIMPLE = (ast.Assign, ast.AugAssign, ast.Expr)
#: What may hold None, or a 0 that counts.
_PLACES = (ast.Name, ast.Subscript, ast.Attribute)
_MAX_VARIABLES, _MAX_EXCHANGED = 14, 5


def insert_missing_copies(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A copy of an argument, or of what is kept."""
    if isinstance(node, ast.Assign) and isinstance(node.value, ast.Name | ast.Subscript):
        yield text.replace_node(node.value, f"np.array({text.source_of(node.value)}, dtype=float)", "copie")
        if isinstance(node.value, ast.Name):
            yield text.replace_node(node.value, f"list({node.value.id})", "copie")
    if isinstance(node, ast.Call) and called_name(node) == "append" and len(node.args) == 1:
        argument = node.args[0]
        if isinstance(argument, ast.Name):
            yield text.replace_node(argument, f"np.array({argument.id})", "copie")


def change_number_types(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Whole or short numbers where real numbers are kept."""
    if not isinstance(node, ast.Call):
        return
    for keyword in node.keywords:
        if keyword.arg == "dtype":
            yield text.replace_node(keyword.value, "float", "type")
    if called_name(node) in ("astype",) and node.args:
        yield text.replace_node(node.args[0], "float", "type")
    if called_name(node) in _MAKERS and not any(keyword.arg == "dtype" for keyword in node.keywords):
        end = text.span(node)[1]
        if len(node.args) == 2 and text.source_of(node.args[1]).split(".")[-1].strip("'\"") in _SHORT_TYPES:
            yield text.replace_node(node.args[1], "float", "type")
        elif node.args:
            yield Change(end - 1, end, ", dtype=float)", "type")
    if called_name(node) in ("int", "round", "float32", "float16", "rint", "trunc") and node.args:
        yield text.replace_node(node, f"({text.source_of(node.args[0])})", "arrondi")


def change_axes(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """An axis where none is named, or the other one; a reduction that is missing or too many."""
    if not isinstance(node, ast.Call) or called_name(node) not in _REDUCERS:
        return
    named = next((keyword for keyword in node.keywords if keyword.arg == "axis"), None)
    end = text.span(node)[1]
    separator = ", " if node.args or node.keywords else ""
    if named is None and text.source_of(node).endswith(")"):
        for axis in (0, 1, -1):
            yield Change(end - 1, end, f"{separator}axis={axis})", "axe")
    elif named is not None:
        for other in ("0", "1", "2", "None"):
            if text.source_of(named.value) != other:
                yield text.replace_node(named.value, other, "axe")


def reorder_statements(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Two neighbouring lines in the other order; a line moved before its block, or to the end of it."""
    for name in ("body", "orelse"):
        block = getattr(node, name, None)
        if not isinstance(block, list):
            continue
        for first, second in itertools.pairwise(block):
            if isinstance(first, _SIMPLE) and isinstance(second, _SIMPLE):
                yield text.swap_nodes(first, second, "ordre des lignes")
        if isinstance(node, ast.For | ast.While) and name == "body" and len(block) > 1:
            yield from _move_last_line_out_of_loop(text, node, block[-1])
    if isinstance(node, ast.FunctionDef | ast.For | ast.While | ast.If):
        yield from _move_next_line_into_loop(text, node)


def sort_what_is_read(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """What is read in the order in which it came, sorted first."""
    values = [node.value] if isinstance(node, ast.Assign) else [node.iter] if isinstance(node, ast.For) else []
    values += [part.iter for part in getattr(node, "generators", ())]
    for value in values:
        if isinstance(value, ast.Name | ast.Attribute | ast.Subscript):
            yield text.replace_node(value, f"sorted({text.source_of(value)})", "rangement")


def _move_last_line_out_of_loop(text: ProgramText, loop: ast.stmt, last: ast.stmt) -> Iterator[Change]:
    """The last line of a loop's block, after the loop."""
    if isinstance(last, ast.Return | ast.Assign | ast.AugAssign | ast.Expr | ast.If) and not loop.orelse:  # type: ignore[attr-defined]
        start, end = text.span(last)
        begin = start - last.col_offset
        lines = text.slice(begin, end).split("\n")
        shift = last.col_offset - loop.col_offset
        if all(line[:shift].isspace() or not line for line in lines):
            yield Change(begin, end, "\n".join(line[shift:] for line in lines), "indentation")


def _move_next_line_into_loop(text: ProgramText, node: ast.stmt) -> Iterator[Change]:
    """The line after a loop, at the end of its block."""
    block = node.body  # type: ignore[attr-defined]
    for loop, after in itertools.pairwise(block):
        if isinstance(loop, ast.For | ast.While) and isinstance(after, _SIMPLE):
            inner = loop.body[0].col_offset - after.col_offset
            start, end = text.span(after)
            begin = start - after.col_offset
            lines = text.slice(begin, end).split("\n")
            yield Change(begin, end, "\n".join(" " * inner + line for line in lines), "indentation")


def replace_variables(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Another variable of the same function."""
    if not isinstance(node, ast.Name) or not isinstance(node.ctx, ast.Load) or node.id in text.import_names:
        return
    if isinstance(text.parent(node), ast.Call) and text.parent(node).func is node:  # type: ignore[attr-defined]
        return
    for other in text.visible_variable_names(node)[:_MAX_VARIABLES]:
        if other != node.id:
            yield text.replace_node(node, other, "variable")


def exchange_variables(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Two variables in each other's place, wherever a statement or an expression reads them."""
    if not isinstance(node, ast.BinOp | ast.BoolOp | ast.Tuple | ast.List | ast.Compare):
        return
    read = [part for part in ast.walk(node) if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Load)]
    names = list(dict.fromkeys(part.id for part in read if part.id in text.visible_variable_names(node)))
    begin, end = text.span(node)
    for first, other in itertools.combinations(names[:_MAX_EXCHANGED], 2):
        pieces, last = [], begin
        for part in sorted((p for p in read if p.id in (first, other)), key=text.span):
            start, stop = text.span(part)
            pieces += [text.slice(last, start), other if part.id == first else first]
            last = stop
        yield Change(begin, end, "".join([*pieces, text.slice(last, end)]), "variables échangées")


def insert_factors(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A sign, a half, a double, a square, a square root, an inverse, an absolute value, a transpose."""
    if not isinstance(node, ast.expr) or isinstance(getattr(node, "ctx", None), ast.Store):
        return
    parent = text.parent(node)
    if not isinstance(node, ast.Name | ast.Call | ast.BinOp | ast.Subscript | ast.Attribute | ast.Constant):
        return
    if isinstance(parent, ast.Attribute | ast.Subscript | ast.keyword | ast.Expr) or (
        isinstance(parent, ast.Call) and parent.func is node
    ):
        return
    if isinstance(node, ast.Constant) and not isinstance(node.value, int | float):
        return
    here = text.source_of(node)
    is_whole = isinstance(parent, ast.Assign | ast.AugAssign | ast.Return | ast.Tuple | ast.List | ast.Call)
    for before, after, operator in (("-(", ")", "signe"), ("(", ") ** 2", "carré"), ("(", ") ** 0.5", "racine"),
                                    ("2 * (", ")", "facteur"), ("(", ") / 2", "facteur"), ("1 / (", ")", "inverse"),
                                    ("np.abs(", ")", "valeur absolue")):  # fmt: skip
        yield text.replace_node(node, f"({before}{here}{after})", operator)
    if is_whole or isinstance(node, ast.Name):
        yield text.replace_node(node, f"({here}).T", "transposée")
        yield text.replace_node(node, f"np.linalg.inv({here})", "inverse")
    if is_whole:
        yield text.replace_node(node, f"np.arctan2(np.sin({here}), np.cos({here}))", "angle")


def add_terms(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A term or a factor more: another variable of the function."""
    if not isinstance(node, ast.BinOp | ast.Call | ast.Name | ast.Subscript):
        return
    parent = text.parent(node)
    is_factor = isinstance(node, ast.Name) and isinstance(parent, ast.BinOp)
    if not is_factor and not isinstance(parent, ast.Assign | ast.AugAssign | ast.Return | ast.Tuple | ast.List):
        return
    if isinstance(getattr(node, "ctx", None), ast.Store):
        return
    here = text.source_of(node)
    for other in text.visible_variable_names(node)[:_MAX_VARIABLES]:
        for sign in "*/" if is_factor else "+-*/@":
            yield text.replace_node(node, f"({here}) {sign} {other}", "terme ou facteur manquant")


def insert_missing_parentheses(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Parentheses that are missing: a sum is divided or multiplied as a whole, an exponent is a quotient."""
    if not isinstance(node, ast.BinOp):
        return
    signs: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
    first, last = node.left, node.right
    if (
        isinstance(node.op, ast.Add | ast.Sub)
        and isinstance(last, ast.BinOp)
        and isinstance(last.op, ast.Div | ast.Mult)
    ):
        parts = [f"({text.source_of(part)})" for part in (first, last.left, last.right)]
        new = f"(({parts[0]} {signs[type(node.op)]} {parts[1]}) {signs[type(last.op)]} {parts[2]})"
        yield text.replace_node(node, new, "parenthèses")
    if isinstance(node.op, ast.Div | ast.Mult) and isinstance(first, ast.BinOp) and isinstance(first.op, ast.Pow):
        parts = [f"({text.source_of(part)})" for part in (first.left, first.right, last)]
        yield text.replace_node(node, f"({parts[0]} ** ({parts[1]} {signs[type(node.op)]} {parts[2]}))", "parenthèses")


def change_conditions(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A statement that is not made under a condition; `while` for `if`; `else` for a second `if`; 0 for no value."""
    tested = node.operand if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not) else None
    if isinstance(tested, _PLACES):
        yield text.replace_node(node, f"({text.source_of(tested)} is None)", "condition")
    if isinstance(node, ast.If | ast.IfExp) and isinstance(node.test, _PLACES):
        yield text.replace_node(node.test, f"({text.source_of(node.test)} is not None)", "condition")
    if isinstance(node, ast.If) and not node.orelse:
        start = text.span(node)[0]
        if text.slice(start, start + 2) == "if":
            yield Change(start, start + 2, "while", "if ou while")
    if isinstance(node, ast.While):
        start = text.span(node)[0]
        yield Change(start, start + 5, "if", "if ou while")
    if isinstance(node, ast.If):
        start = text.span(node)[0]
        if text.slice(start, start + 4) == "elif":
            yield Change(start, start + 4, "if", "elif ou if")


def turn_assignments_into_additions(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """« += » for « = »."""
    if (
        isinstance(node, ast.Assign)
        and len(node.targets) == 1
        and isinstance(node.targets[0], ast.Subscript | ast.Name)
    ):
        start, end = text.operator_span(node.targets[0], node.value, "=")
        for sign in "+-":
            yield Change(start, end, f"{sign}=", "affectation")


LIKELY = (
    insert_missing_copies,
    change_number_types,
    change_axes,
    reorder_statements,
    change_conditions,
    turn_assignments_into_additions,
    insert_missing_parentheses,
)
UNLIKELY = (replace_variables, exchange_variables, sort_what_is_read, insert_factors, add_terms)
