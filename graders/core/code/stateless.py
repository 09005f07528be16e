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
from collections.abc import Callable, Collection, Mapping
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

#: A longer text is not looked at.
LONGEST = 10_000
_MODULES = {"numpy": np, "math": math}

#: What a function may be made of. Neither `try`, which may hide that time ran out, nor what has other scopes.
_ALLOWED = (
    *(
        ast.FunctionDef,
        ast.Lambda,
        ast.arguments,
        ast.arg,
        ast.keyword,
        ast.Expr,
        ast.Return,
        ast.Assign,
        ast.AugAssign,
    ),
    *(ast.AnnAssign, ast.For, ast.While, ast.If, ast.Break, ast.Continue, ast.Pass, ast.Raise, ast.Assert),
    *(ast.comprehension, ast.ListComp, ast.GeneratorExp, ast.BoolOp, ast.BinOp, ast.UnaryOp, ast.IfExp, ast.Compare),
    *(ast.Call, ast.Constant, ast.Attribute, ast.Subscript, ast.Slice, ast.Starred, ast.Name, ast.List, ast.Tuple),
)
#: And a number that functions share.
_CONSTANT = frozenset((ast.Constant, ast.Tuple, ast.UnaryOp, ast.BinOp, ast.Name, ast.Attribute))
#: Fields of these that hold no part of the program: names, signs, and what is no code.
_NO_PART = frozenset(("arg", "attr", "ctx", "id", "is_async", "kind", "name", "op", "ops", "simple", "type_comment"))
_PARTS = {kind: tuple(name for name in kind._fields if name not in _NO_PART) for kind in _ALLOWED} | {ast.Constant: ()}
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


def _bound(statement: ast.stmt, shared: AbstractSet[str]) -> set[str] | None:
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
            return {name} if _is_harmless(value, shared, (), _CONSTANT) else None
    return None


def _is_harmless(
    tree: ast.AST, shared: AbstractSet[str], hidden: Collection[str], kinds: Collection[type] = _PARTS.keys()
) -> bool:
    """Whether a function works with its own names and with those that are shared only; `hidden` are others' names."""
    read, own = set[str](), set[str]()
    waiting: list[Any] = [tree]
    while waiting:
        node = waiting.pop()
        kind = type(node)
        if kind not in kinds or not _CHECKS.get(kind, _nothing)(node):
            return False
        if kind is ast.Name:
            (read if type(node.ctx) is ast.Load else own).add(node.id)
        elif kind is ast.arg or kind is ast.FunctionDef:
            own.add(node.arg if kind is ast.arg else node.name)
        for name in _PARTS[kind]:
            part = getattr(node, name)
            if type(part) is list:
                waiting += [one for one in part if one is not None]
            elif part is not None:
                waiting.append(part)
    return own.isdisjoint(hidden) and read <= own | shared


def _nothing(node: Any) -> bool:
    """There is nothing more to be seen of it."""
    return True


def _attribute(node: Any) -> bool:
    return node.attr in _ATTRIBUTES and isinstance(node.ctx, ast.Load)


def _keyword(node: Any) -> bool:
    return node.arg is not None and node.arg != _UNWRITTEN


def _function(node: Any) -> bool:
    """What is decorated may be kept by who decorates it; a default that is no constant is shared by all calls."""
    defaults = (*node.args.defaults, *node.args.kw_defaults)
    return not getattr(node, "decorator_list", ()) and all(one is None or type(one) is ast.Constant for one in defaults)


def _comparison(node: Any) -> bool:
    """Which objects are the same one is nobody's business."""
    pairs = zip(node.ops, node.comparators, strict=True)
    return all(_is_none(other) for sign, other in pairs if isinstance(sign, ast.Is | ast.IsNot))


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _annotated(node: Any) -> bool:
    return isinstance(node.target, ast.Name)


_CHECKS: dict[type, Callable[[Any], bool]] = {
    ast.Attribute: _attribute,
    ast.keyword: _keyword,
    ast.FunctionDef: _function,
    ast.Lambda: _function,
    ast.Compare: _comparison,
    ast.AnnAssign: _annotated,
}
