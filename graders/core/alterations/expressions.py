"""Alterations of expressions: operators, constants, comparisons, indices, displays."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator

from graders.core.alterations.text import Change, ProgramText

#: Operators with which each operator is confused.
BINARY = {
    ast.Add: ("+", ("-", "*")),
    ast.Sub: ("-", ("+", "*")),
    ast.Mult: ("*", ("/", "+")),
    ast.Div: ("/", ("*", "-")),
    ast.FloorDiv: ("//", ("/", "*")),
    ast.Mod: ("%", ("*", "//")),
    ast.Pow: ("**", ("*",)),
    ast.MatMult: ("@", ("*",)),
    ast.BitAnd: ("&", ("|",)),
    ast.BitOr: ("|", ("&",)),
    ast.BitXor: ("^", ("|",)),
}
#: Operators of which one operand makes sense alone: the left one, and the right one.
LEFT_ALONE = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow, ast.BitAnd, ast.BitOr)
RIGHT_ALONE = (ast.Add, ast.Sub, ast.Mult, ast.BitAnd, ast.BitOr)
COMPARED = {
    ast.Lt: ("<", ("<=", ">=")),
    ast.LtE: ("<=", ("<", ">")),
    ast.Gt: (">", (">=", "<=")),
    ast.GtE: (">=", (">", "<")),
    ast.Eq: ("==", ("!=",)),
    ast.NotEq: ("!=", ("==",)),
    ast.In: ("in", ("not in",)),
    ast.NotIn: ("not in", ("in",)),
    ast.Is: ("is", ("is not",)),
    ast.IsNot: ("is not", ("is",)),
}
#: Up to this a constant is a tolerance: twice it, or its opposite, changes nothing that is worth asking.
TOLERANCE = 1e-6
#: Names of rows and columns, which go in pairs.
AXES = frozenset(map(frozenset, ("xy", "hw", "ij", ("dx", "dy"), ("ligne", "colonne"), ("lignes", "colonnes"))))
#: Neighbours that are swapped in one list or tuple.
MAX_SWAPS = 4


def alter_numbers(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A number, a little more, a little less, none, of the other sign, twice as much; True for False."""
    if not isinstance(node, ast.Constant) or node.value is None:
        return
    value = node.value
    if isinstance(value, bool):
        yield text.replace_node(node, str(not value), "constante")
    elif isinstance(value, complex):
        if not isinstance(text.parent(node), ast.UnaryOp):
            yield text.replace_node(node, f"(-{text.source_of(node)})", "rotation transposée", own=True)
    elif isinstance(value, int | float):
        own = _is_axis_number(text, node)
        for other in dict.fromkeys(_iter_other_numbers(text, node, value)):
            written = f"({other!r})" if other < 0 and isinstance(text.parent(node), ast.BinOp) else repr(other)
            yield text.replace_node(node, written, "axe" if own else "constante", own=own)


def _iter_other_numbers(text: ProgramText, node: ast.AST, value: float) -> Iterator[float]:
    parent = text.parent(node)
    signed = isinstance(parent, ast.UnaryOp)
    term = isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.Add | ast.Sub) and parent.right is node
    if _is_axis_number(text, node) and not signed:
        yield 1 - value if value in (0, 1) else 0
    elif _is_index(text, node):
        yield from (value + 1, value - 1) if not signed else (value + 1, *((value - 1,) if value > 1 else ()))
    elif 0 < abs(value) <= TOLERANCE:
        yield from (0.0, 1.0)
    else:  # a term left out and a sign are the operator's business
        match = (
            value + 1,
            value - 1,
            2 * value,
            *(() if term else (value - value,)),
            *(() if signed or term else (-value,)),
        )
        yield from (other for other in match if other != value and not (term and other == 0))


def _is_axis_number(text: ProgramText, node: ast.AST) -> bool:
    """Is it the number of an axis: `axis=…`, or what `shape` is asked for?"""
    parent = text.parent(node)
    if isinstance(parent, ast.keyword):
        return parent.arg == "axis"
    return (
        isinstance(parent, ast.Subscript) and isinstance(parent.value, ast.Attribute) and parent.value.attr == "shape"
    )


def _is_index(text: ProgramText, node: ast.AST) -> bool:
    while isinstance(text.parent(node), ast.UnaryOp | ast.Tuple):
        node = text.parent(node)
    parent = text.parent(node)
    return isinstance(parent, ast.Slice) or (isinstance(parent, ast.Subscript) and parent.slice is node)


def alter_binary_operations(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Another operator, an operand alone, the operands of a difference or of a product of matrices swapped."""
    if not isinstance(node, ast.BinOp) or _has_text_operand(node) or type(node.op) not in BINARY:
        return
    spelled, others = BINARY[type(node.op)]
    start, end = text.operator_span(node.left, node.right, spelled)
    for other in others:
        yield Change(start, end, other, "opérateur")
    first, last = text.span(node)
    if isinstance(node.op, LEFT_ALONE):
        own = is_normalisation(node)
        yield Change(
            first, last, text.slice(first, start).rstrip(), "normalisation oubliée" if own else "terme oublié", own
        )
    if isinstance(node.op, RIGHT_ALONE):
        yield Change(first, last, text.slice(end, last).lstrip(), "terme oublié")
    if isinstance(node.op, ast.Sub | ast.MatMult):
        own = isinstance(node.op, ast.MatMult)
        right, left = text.slice(end, last).strip(), text.slice(first, start).strip()
        words = "ordre du produit" if own else "opérandes échangés"
        yield Change(
            first,
            last,
            f"{_parenthesise_if_needed(node.right, right)} {spelled} {_parenthesise_if_needed(node.left, left)}",
            words,
            own,
        )


def _parenthesise_if_needed(node: ast.expr, text: str) -> str:
    """An operand in the place of another one: it stays one."""
    return f"({text})" if isinstance(node, ast.BinOp) and not text.startswith("(") else text


def _has_text_operand(node: ast.BinOp) -> bool:
    return any(isinstance(side, ast.Constant) and isinstance(side.value, str) for side in (node.left, node.right))


def is_normalisation(node: ast.BinOp) -> bool:
    """Does it divide by a sum or a norm, or bring an angle back by a remainder?"""
    if isinstance(node.op, ast.Div):
        return not isinstance(node.left, ast.Constant) and any(
            isinstance(part, ast.Call) and called_name(part) in ("sum", "norm", "hypot")
            for part in ast.walk(node.right)
        )
    return isinstance(node.op, ast.Mod) and any(_is_pi_or_tau(part) for part in ast.walk(node.right))


def _is_pi_or_tau(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and node.attr in ("pi", "tau")


def called_name(call: ast.Call) -> str:
    """The last word of what is called, "" where it has no name."""
    function = call.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def drop_unary_operators(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """A sign, a « not », a « ~ » dropped."""
    if isinstance(node, ast.UnaryOp):
        first, last = text.span(node)
        length = len("not") if isinstance(node.op, ast.Not) else 1
        yield Change(first, last, text.slice(first + length, last).lstrip(), "signe ou négation oubliés")


def alter_comparisons(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Strict for not strict, the contrary; one of two bounds alone."""
    if not isinstance(node, ast.Compare):
        return
    operands = [node.left, *node.comparators]
    for left, right, op in zip(operands, node.comparators, node.ops, strict=False):
        spelled, others = COMPARED[type(op)]
        for other in others:
            yield Change(*text.operator_span(left, right, spelled), other, "comparaison")
    if len(node.ops) == 2:
        (first, last), (start, end) = text.span(node), text.span(node.comparators[0])
        yield Change(first, last, text.slice(first, end), "borne oubliée")
        yield Change(first, last, text.slice(start, last), "borne oubliée")


def alter_boolean_operations(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """« and » for « or », one of the conditions dropped."""
    if not isinstance(node, ast.BoolOp):
        return
    spelled, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
    for left, right in zip(node.values, node.values[1:], strict=False):
        start, end = text.operator_span(left, right, spelled)
        yield Change(start, end, other, "et, ou")
    bounds = [text.operator_span(*pair, spelled) for pair in zip(node.values, node.values[1:], strict=False)]
    first, last = text.span(node)
    yield Change(first, bounds[0][1], "", "condition oubliée")
    for index, (start, _) in enumerate(bounds):
        stop = bounds[index + 1][0] if index + 1 < len(bounds) else last
        yield Change(start, stop, "", "condition oubliée")


def choose_conditional_branches(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """One branch of « a if c else b » whatever c."""
    if isinstance(node, ast.IfExp):
        yield text.replace_node(node, f"({text.source_of(node.body)})", "branche")
        yield text.replace_node(node, f"({text.source_of(node.orelse)})", "branche")


def shift_indices(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """An index or a bound off by one; row and column swapped."""
    if not isinstance(node, ast.Subscript):
        return
    parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    for part in parts:
        yield from _alter_slice_bounds(text, part) if isinstance(part, ast.Slice) else _shift_index_by_one(text, part)
    if len(parts) == 2 and text.source_of(parts[0]) != text.source_of(parts[1]):
        yield text.swap_nodes(parts[0], parts[1], "ligne et colonne", own=True)


def _alter_slice_bounds(text: ProgramText, part: ast.Slice) -> Iterator[Change]:
    for bound in (part.lower, part.upper):
        if bound is not None:
            yield from _shift_index_by_one(text, bound)
    start, end = text.span(part)
    if part.lower is None and part.upper is not None:
        yield Change(start, start, "1", "indice décalé")
    if part.upper is None and part.lower is not None and part.step is None:
        yield Change(end, end, "-1", "indice décalé")


def _shift_index_by_one(text: ProgramText, node: ast.expr) -> Iterator[Change]:
    """Numbers alone are altered as constants; masks and lists are no indices."""
    bare = node.operand if isinstance(node, ast.UnaryOp) else node
    if not isinstance(bare, ast.Constant | ast.Compare | ast.List | ast.BoolOp):
        for sign in "+-":
            yield text.replace_node(node, f"{text.source_of(node)} {sign} 1", "indice décalé")


def swap_list_neighbours(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Two neighbours of a list or a tuple swapped, of what is returned or unpacked too; not those of an index."""
    if not isinstance(node, ast.List | ast.Tuple) or isinstance(text.parent(node), ast.Subscript):
        return
    for first, second in list(zip(node.elts, node.elts[1:], strict=False))[:MAX_SWAPS]:
        if text.source_of(first) != text.source_of(second):
            own = frozenset(text.source_of(display).lower() for display in (first, second)) in AXES
            yield text.swap_nodes(first, second, "ligne et colonne" if own else "ordre", own=own)


def replace_two_pi_by_pi(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """π for 2π, where π has a name."""
    if isinstance(node, ast.Attribute) and node.attr == "pi":
        yield text.replace_node(node, f"(2 * {text.source_of(node)})", "constante")
    if isinstance(node, ast.Attribute) and node.attr == "tau":
        yield text.replace_node(node, f"({text.source_of(node)} / 2)", "constante")
    if isinstance(node, ast.Attribute) and node.attr == "inf":
        yield text.replace_node(node, "0.0", "constante")


DEGREES = repr(180 / math.pi)
RULES = (
    alter_numbers,
    alter_binary_operations,
    drop_unary_operators,
    alter_comparisons,
    alter_boolean_operations,
    choose_conditional_branches,
    shift_indices,
    swap_list_neighbours,
    replace_two_pi_by_pi,
)
