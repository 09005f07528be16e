"""Programs that are seen, in their text, to keep nothing from one call to the next: what they answer depends on what
they are given and on nothing else.

Such a program need not be launched afresh to be asked what must not depend on what it was asked before. Whatever is not
seen here to be harmless is not: a program is believed to remember as long as its text leaves any doubt. What may be
written is what no state can be kept in: functions, the numbers that they share, arithmetic, loops, and functions of
numpy and math that give the same for the same arguments.
"""

from __future__ import annotations

import ast
import builtins
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

import numpy as np

#: A longer text is not looked at.
LONGEST = 10_000
_MODULES = {"numpy": np, "math": math}

#: What nothing is wrong with by itself. Neither `try`, which may hide that time ran out, nor what has other scopes.
_HARMLESS = frozenset(
    (
        *(ast.arguments, ast.arg, ast.Expr, ast.Return, ast.Assign, ast.AugAssign, ast.For, ast.While, ast.If),
        *(ast.Break, ast.Continue, ast.Pass, ast.Raise, ast.Assert, ast.comprehension, ast.ListComp, ast.GeneratorExp),
        *(ast.BoolOp, ast.BinOp, ast.UnaryOp, ast.IfExp, ast.Call, ast.Constant, ast.Subscript, ast.Slice, ast.Starred),
        *(ast.List, ast.Tuple),
    )
)
#: What a number that functions share may be made of.
_CONSTANT = frozenset((ast.Constant, ast.Tuple, ast.UnaryOp, ast.BinOp, ast.Name, ast.Attribute))
#: What stands in a tree for `+`, `not`, `<`, and for being read or written.
_SIGNS = (ast.operator, ast.unaryop, ast.boolop, ast.cmpop, ast.expr_context)
_BUILTINS = frozenset(
    """
    abs all any bool complex divmod enumerate float int len list max min pow range reversed round sorted sum tuple zip
    ArithmeticError IndexError TypeError ValueError ZeroDivisionError
    """.split()  # noqa: SIM905
)
#: What no program may call its own: it may then mean the other.
_HIDDEN = frozenset(("__builtins__", *vars(builtins))) - _BUILTINS
#: By whatever they are read of: numpy, math, arrays, lists and numbers. None gives memory that was not written before
#: (`empty`), what others share (`base`), chance, or anything of the machine.
_ATTRIBUTES = frozenset(
    """
    T abs absolute acos add all angle any append arange arccos arcsin arctan arctan2 argmax argmin argsort array
    asarray asin astype atan atan2 atleast_1d atleast_2d bool_ ceil clip column_stack concatenate conj conjugate
    copy copysign cos cosh cross cumprod cumsum deg2rad degrees det diag diff divide dot dtype e einsum exp extend
    eye fabs flat flatten float32 float64 floor fmod full full_like hstack hypot identity imag inf insert int32
    int64 inv isclose isfinite isnan item linalg linspace log log10 log2 matmul max maximum mean min minimum mod
    multiply nan ndim newaxis norm ones ones_like outer pi power prod rad2deg radians ravel real remainder repeat
    reshape rint roll round shape sign sin sinh size solve sort sqrt square squeeze stack std subtract sum svd
    swapaxes tan tanh tau tile tolist trace transpose trunc var vdot vstack where zeros zeros_like
    """.split()  # noqa: SIM905
)
#: An argument by which numpy leaves places of its result unwritten.
_UNWRITTEN = "where"


def is_stateless(source: bytes, given: Mapping[str, Any]) -> bool:
    """Whether no call of a program can be seen in its later ones; `given` are the names that it finds in its kit."""
    if len(source) > LONGEST or "__drivers__" in given:
        return False
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    known = {name for name, value in given.items() if any(value is module for module in _MODULES.values())}
    shared = set(_BUILTINS - given.keys()) | known
    hidden = given.keys() - known | _HIDDEN
    for statement in tree.body:
        bound = _bound(statement, shared)
        if bound is None or not bound.isdisjoint(hidden):
            return False
        shared |= bound
    functions = [statement for statement in tree.body if isinstance(statement, ast.FunctionDef)]
    return all(_is_harmless(function, shared, hidden) for function in functions)


def _bound(statement: ast.stmt, shared: Collection[str]) -> set[str] | None:
    """The names that a statement of the module gives; None of one that may do something else."""
    match statement:
        case ast.FunctionDef():
            return {statement.name}
        case ast.Expr(value=ast.Constant()):
            return set()
        case ast.Import(names=names) if all(one.name in _MODULES for one in names):
            return {one.asname or one.name for one in names}
        case ast.ImportFrom(module=module, names=names, level=0) if module in _MODULES:
            return {one.asname or one.name for one in names} if {one.name for one in names} <= _ATTRIBUTES else None
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            return {name} if all(_is_constant(node, shared) for node in _nodes(value)) else None
    return None


def _is_constant(node: ast.AST, shared: Collection[str]) -> bool:
    return type(node) in _CONSTANT and _is_allowed(node, shared)


def _is_harmless(function: ast.FunctionDef, shared: Collection[str], hidden: Collection[str]) -> bool:
    """Whether a function only works with its own names, and with those that are shared; `hidden` are others' names."""
    nodes = list(_nodes(function))
    own = {name for node in nodes if (name := _given(node)) is not None}
    names = own.union(shared)
    return own.isdisjoint(hidden) and all(type(node) in _HARMLESS or _is_allowed(node, names) for node in nodes)


def _nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """As `ast.walk`, without the signs."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        for value in vars(node).values():
            if isinstance(value, list):
                waiting += [one for one in value if isinstance(one, ast.AST) and not isinstance(one, _SIGNS)]
            elif isinstance(value, ast.AST) and not isinstance(value, _SIGNS):
                waiting.append(value)


def _given(node: ast.AST) -> str | None:
    """The name that something is given here."""
    if isinstance(node, ast.Name):
        return None if isinstance(node.ctx, ast.Load) else node.id
    return node.arg if isinstance(node, ast.arg) else node.name if isinstance(node, ast.FunctionDef) else None


def _is_allowed(node: ast.AST, names: Collection[str]) -> bool:
    """Of what is not harmless by itself."""
    allowed = _ALLOWED.get(type(node))
    return type(node) in _HARMLESS if allowed is None else allowed(node, names)


def _name(node: Any, names: Collection[str]) -> bool:
    return node.id in names or not isinstance(node.ctx, ast.Load)


def _attribute(node: Any, names: Collection[str]) -> bool:
    return node.attr in _ATTRIBUTES and isinstance(node.ctx, ast.Load)


def _keyword(node: Any, names: Collection[str]) -> bool:
    return node.arg is not None and node.arg != _UNWRITTEN


def _function(node: Any, names: Collection[str]) -> bool:
    """What is decorated may be kept by who decorates it; a default that is no constant is shared by all calls."""
    defaults = (*node.args.defaults, *node.args.kw_defaults)
    return not getattr(node, "decorator_list", ()) and all(one is None or type(one) is ast.Constant for one in defaults)


def _comparison(node: Any, names: Collection[str]) -> bool:
    """Which objects are the same one is nobody's business."""
    pairs = zip(node.ops, node.comparators, strict=True)
    return all(_is_none(other) for sign, other in pairs if isinstance(sign, ast.Is | ast.IsNot))


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _annotated(node: Any, names: Collection[str]) -> bool:
    return isinstance(node.target, ast.Name)


_ALLOWED: dict[type, Callable[[Any, Collection[str]], bool]] = {
    ast.Name: _name,
    ast.Attribute: _attribute,
    ast.keyword: _keyword,
    ast.FunctionDef: _function,
    ast.Lambda: _function,
    ast.Compare: _comparison,
    ast.AnnAssign: _annotated,
}
