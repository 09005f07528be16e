"""Alterations of calls: the function, its arguments and their order; and the course's own mistakes."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from graders.core.alterations.expressions import DEGREES, called_name
from graders.core.alterations.text import Change, ProgramText


def split_words(text: str) -> frozenset[str]:
    """Return a set of names from a text separated by spaces."""
    return frozenset(text.split())


#: Pairs of functions that are confused with each other.
NEIGHBOURS = """
    sin cos, min max, minimum maximum, argmin argmax, fmin fmax, amin amax, nanmin nanmax, nanargmin nanargmax,
    sum mean, nansum nanmean, floor ceil, any all, zeros ones, zeros_like ones_like, std var, cumsum cumprod,
    logical_and logical_or, vstack hstack, append extend, log log10
"""
TAKEN_FOR = {
    name: other for pair in NEIGHBOURS.split(",") for name, other in (pair.split(), reversed(pair.split()))
} | {
    "round": "floor",
    "rint": "floor",
    "trunc": "ceil",
    "median": "mean",
    "prod": "sum",
    "tan": "sin",
}
#: Functions whose call may be forgotten, leaving the first argument.
DROPPED = split_words(
    """
    abs fabs absolute sqrt exp log log1p expm1 clip copy deepcopy array sorted sort round rint floor ceil trunc int
    cumsum unique sign square transpose angle phase radians degrees deg2rad rad2deg unwrap mod fmod remainder
    minimum maximum min max hypot norm flip roll reversed conj conjugate atleast_2d diff nan_to_num ravel
    """
)
#: Methods whose call may be forgotten, leaving the object.
METHODS = split_words("copy clip cumsum round transpose conj conjugate ravel flatten sort reverse astype")
#: Functions that are symmetric in their arguments.
SYMMETRIC = split_words(
    "hypot minimum maximum min max fmin fmax logical_and logical_or logical_xor isclose allclose add multiply"
)
COMPOSITION = split_words("composer compose relatif relative matmul multi_dot")
WRAP = re.compile("ramen|wrap|normalis|normaliz|modulo|arctan2|atan2|angle|phase")
ANGLE_IN = split_words("sin cos tan")
ANGLE_OUT = split_words("arctan2 atan2 arctan atan arccos acos arcsin asin angle phase")


def alter_calls(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """Another function, the call dropped, its arguments swapped, a named one dropped."""
    if not isinstance(node, ast.Call):
        return
    yield from _replace_by_confusable_function(text, node)
    yield from _drop_call_to_argument(text, node)
    yield from _swap_arguments(text, node)
    yield from _drop_keyword_argument(text, node)
    yield from _shift_range_bounds(text, node)
    yield from _choose_where_branch(text, node)


def _replace_by_confusable_function(text: ProgramText, node: ast.Call) -> Iterator[Change]:
    other = TAKEN_FOR.get(called_name(node))
    if other is not None and (isinstance(node.func, ast.Attribute) or other in ("min", "max", "any", "all")):
        end = text.span(node.func)[1]
        yield Change(end - len(called_name(node)), end, other, "fonction voisine")
    if called_name(node) in ("arctan2", "atan2") and len(node.args) == 2:
        up, right = (text.source_of(arg) for arg in node.args)
        name = text.source_of(node.func).replace("2", "")
        yield text.replace_node(node, f"{name}(({up}) / ({right}))", "fonction voisine")


def _is_method_call(text: ProgramText, node: ast.Call) -> bool:
    """Whether a call is a method of a value, rather than a function of a module."""
    root: ast.expr = node.func
    while isinstance(root, ast.Attribute):
        root = root.value
    return isinstance(node.func, ast.Attribute) and not (isinstance(root, ast.Name) and root.id in text.import_names)


def _drop_call_to_argument(text: ProgramText, node: ast.Call) -> Iterator[Change]:
    if isinstance(text.parent(node), ast.Expr):
        return
    if _is_method_call(text, node):
        assert isinstance(node.func, ast.Attribute)
        if node.func.attr in METHODS or WRAP.search(node.func.attr):
            yield from _replace_call_by_argument(text, node, node.func.value)
        elif len(node.args) == 1:
            yield from _drop_call_of_own_function(text, node)
        return
    if called_name(node) == "array" and isinstance(node.args[0], ast.List | ast.Tuple | ast.ListComp):
        return
    if called_name(node) in DROPPED or WRAP.search(called_name(node)):
        for argument in node.args[: 2 if called_name(node) in SYMMETRIC else 1]:
            yield from _replace_call_by_argument(text, node, argument)
    elif len(node.args) == 1:
        yield from _drop_call_of_own_function(text, node)


def _replace_call_by_argument(text: ProgramText, node: ast.Call, argument: ast.expr) -> Iterator[Change]:
    if isinstance(argument, ast.Starred | ast.GeneratorExp):
        return
    own = bool(WRAP.search(called_name(node)))
    remaining = (
        _wrapped_angle_source(text, argument)
        if called_name(node) in ("arctan2", "atan2", "angle", "phase")
        else text.source_of(argument)
    )
    if remaining is not None:
        yield text.replace_node(node, f"({remaining})", "normalisation oubliée" if own else "appel oublié", own=own)


def _wrapped_angle_source(text: ProgramText, node: ast.expr) -> str | None:
    """Return x of arctan2(sin x, cos x) or angle(exp(1j x)); None for another argument."""
    if isinstance(node, ast.Call) and called_name(node) == "sin":
        return text.source_of(node.args[0])
    if isinstance(node, ast.Call) and called_name(node) == "exp" and isinstance(node.args[0], ast.BinOp):
        return text.source_of(node.args[0].right)
    return None


def _drop_call_of_own_function(text: ProgramText, node: ast.Call) -> Iterator[Change]:
    """Replace a call of a function of the file by its only argument."""
    names = {function.name for function in ast.walk(text.tree) if isinstance(function, ast.FunctionDef)}
    if called_name(node) in names:
        yield from _replace_call_by_argument(text, node, node.args[0])


def _swap_arguments(text: ProgramText, node: ast.Call) -> Iterator[Change]:
    if called_name(node) in SYMMETRIC or any(isinstance(arg, ast.Starred) for arg in node.args):
        return
    own = called_name(node) in COMPOSITION
    for first, second in zip(node.args, node.args[1:], strict=False):
        if text.source_of(first) != text.source_of(second):
            yield text.swap_nodes(first, second, "ordre de la composition" if own else "arguments échangés", own=own)


def _drop_keyword_argument(text: ProgramText, node: ast.Call) -> Iterator[Change]:
    """A named argument left out; a type that is asked for is a precaution, and is not altered."""
    for keyword in node.keywords:
        if keyword.arg in (None, "dtype", "key"):
            continue
        start, end = text.span(keyword)
        before = text.slice(0, start).rstrip()
        comma = before.endswith(",")
        first = len(before.encode()) - 1 if comma else start
        yield Change(first, end, "", "axe" if keyword.arg == "axis" else "argument oublié", keyword.arg == "axis")


def _shift_range_bounds(text: ProgramText, node: ast.Call) -> Iterator[Change]:
    """A range that begins or ends one off; numbers alone are altered as constants."""
    if called_name(node) not in ("range", "arange"):
        return
    for argument in node.args[:2]:
        if not isinstance(argument, ast.Constant | ast.Starred):
            for sign in "+-":
                yield text.replace_node(argument, f"{text.source_of(argument)} {sign} 1", "intervalle décalé")
    if len(node.args) == 1:
        start = text.span(node.args[0])[0]
        yield Change(start, start, "1, ", "intervalle décalé")


def _choose_where_branch(text: ProgramText, node: ast.Call) -> Iterator[Change]:
    if called_name(node) == "where" and len(node.args) == 3:
        for argument in node.args[1:]:
            yield text.replace_node(node, f"({text.source_of(argument)})", "branche")


def transpose_rotations(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """The rotation the other way round: the sine of the other sign, a matrix for its transpose."""
    if isinstance(node, ast.Call) and called_name(node) == "sin" and len(node.args) == 1:
        yield text.replace_node(node, f"(-{text.source_of(node)})", "rotation transposée", own=True)
    if isinstance(node, ast.Attribute) and node.attr == "T":
        yield text.replace_node(
            node,
            text.slice(text.span(node)[0], text.span(node.value)[1]) + _closing_parentheses(text, node),
            "transposée",
            own=True,
        )
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        for side in (node.left, node.right):
            if isinstance(side, ast.Name) and side.id[:1].isupper():
                yield text.replace_node(side, f"{side.id}.T", "transposée", own=True)


def _closing_parentheses(text: ProgramText, node: ast.Attribute) -> str:
    """Return the closing parentheses between a value and its attribute's dot."""
    return text.slice(text.span(node.value)[1], text.span(node)[1]).rsplit(".", 1)[0]


def alter_angle_units(text: ProgramText, node: ast.AST) -> Iterator[Change]:
    """An angle in degrees where radians are meant: given to a sine, or got of an arc tangent."""
    if not isinstance(node, ast.Call):
        return
    if called_name(node) in ANGLE_IN and len(node.args) == 1:
        yield text.replace_node(node.args[0], f"{DEGREES} * ({text.source_of(node.args[0])})", "degrés", own=True)
    if called_name(node) in ANGLE_OUT:
        yield text.replace_node(node, f"({DEGREES} * {text.source_of(node)})", "degrés", own=True)
    if called_name(node) == "exp" and any(
        isinstance(part, ast.Constant) and isinstance(part.value, complex) for part in ast.walk(node)
    ):
        yield text.replace_node(node.args[0], f"{DEGREES} * {text.source_of(node.args[0])}", "degrés", own=True)


RULES = (alter_calls, transpose_rotations, alter_angle_units)
