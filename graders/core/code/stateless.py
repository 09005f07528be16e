"""Static check that a program keeps no state between calls, so that its answers depend on the arguments only.

A stateless program needs no fresh launch before its probes. The check is an allow-list, and in doubt a program counts
as stateful. Allowed are functions, shared numeric constants, arithmetic, loops, and deterministic functions of numpy
and math.
"""

from __future__ import annotations

import ast
import builtins
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

from graders.core.syntax_trees import parse_or_none

#: Characters; a longer text counts as stateful.
MAX_SOURCE = 10_000
_MODULES = {"numpy": np, "math": math}

#: Allowed nodes of a function. Not `try`, which may hide a timeout, nor nodes with other scopes.
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
#: Allowed nodes of a shared constant.
_CONSTANT = frozenset((ast.Constant, ast.Tuple, ast.UnaryOp, ast.BinOp, ast.Name, ast.Attribute))
#: Fields of these nodes without child nodes to check: names, operators, contexts.
_NO_PART = frozenset(("arg", "attr", "ctx", "id", "is_async", "kind", "name", "op", "ops", "simple", "type_comment"))
_PARTS = {kind: tuple(name for name in kind._fields if name not in _NO_PART) for kind in _ALLOWED} | {ast.Constant: ()}
_BUILTINS = frozenset(
    """
    abs all any bool complex divmod enumerate float int len list max min pow range reversed round sorted sum tuple zip
    ArithmeticError IndexError TypeError ValueError ZeroDivisionError
    """.split()  # noqa: SIM905
)
#: Names that no program may redefine.
_HIDDEN = frozenset(("__builtins__", *vars(builtins))) - _BUILTINS
#: Allowed attributes of any object: numpy, math, arrays, lists, numbers. None gives uninitialised memory (`empty`),
#: shared memory (`base`), random numbers, or anything of the machine.
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
#: Values that a program may change in place.
_MUTABLE = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp, ast.Call)
#: Makers of containers that are filled later; methods that write into one.
_CONTAINERS = frozenset(("dict", "list", "set", "defaultdict", "OrderedDict", "Counter", "deque", "SimpleNamespace"))
_WRITERS = frozenset(("append", "extend", "insert", "update", "setdefault", "add", "fill", "put", "__setitem__"))
#: A keyword argument by which numpy leaves a part of its result uninitialised.
_UNWRITTEN = "where"


def is_stateless(source: bytes, kit_names: Mapping[str, Any]) -> bool:
    """Whether the calls of a program cannot influence later ones; `kit_names` are the names of its kit."""
    if len(source) > MAX_SOURCE or "__drivers__" in kit_names:
        return False
    tree = parse_or_none(source)
    if tree is None:
        return False
    module_names = {name for name, value in kit_names.items() if any(value is module for module in _MODULES.values())}
    shared = set(_BUILTINS - kit_names.keys()) | module_names
    hidden = kit_names.keys() - module_names | _HIDDEN
    for statement in tree.body:
        bound = _names_bound_by(statement, shared)
        if bound is None or not bound.isdisjoint(hidden):
            return False
        shared |= bound
    functions = [statement for statement in tree.body if isinstance(statement, ast.FunctionDef)]
    return all(_is_harmless(function, shared, hidden) for function in functions)


def may_keep_state(source: bytes) -> bool:
    """Whether the text of a program shows where it may keep something from one call to the next.

    That is a global variable that a function sets, a mutable value at the top level that is read somewhere, or as a
    default or an attribute of a class, an attribute of a function or of a class that is set, a decorator.
    """
    tree = parse_or_none(source[:MAX_SOURCE])
    if tree is None:
        return False
    nodes = list(ast.walk(tree))  # once: a right program waits for this too
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef)]
    classes = [node for node in nodes if isinstance(node, ast.ClassDef)]
    names = {function.name for function in functions} | {node.name for node in classes}
    read = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
    kept = [
        statement.value
        for statement in tree.body
        if isinstance(statement, ast.Assign | ast.AnnAssign) and _may_assign_read_name(statement, read)
    ]
    own = [part for node in classes for part in node.body if isinstance(part, ast.Assign | ast.AnnAssign)]
    kept += [statement.value for statement in own]
    defaults = [default for function in functions for default in function.args.defaults]
    return (
        any(isinstance(node, ast.Global | ast.Nonlocal) for node in nodes)
        or any(isinstance(part, _MUTABLE) for value in [*kept, *defaults] for part in _tuple_elements(value))
        or any(function.decorator_list for function in functions)
        or any(_sets_attribute(node, names) for node in nodes)
    )


def may_change_state(source: bytes) -> bool:
    """Whether the text of a program shows where a function may write what a later call reads.

    As `may_keep_state`, but for constants: a filled container or an array of the top level counts only where it is
    written to. An empty one, or one of a class or a function of the program, counts where it is read.
    """
    tree = parse_or_none(source[:MAX_SOURCE])
    if tree is None or not may_keep_state(source):
        return False
    nodes = list(ast.walk(tree))
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    classes = {node.name for node in nodes if isinstance(node, ast.ClassDef)}
    own = classes | {function.name for function in functions}
    defaults = [default for function in functions for default in (*function.args.defaults, *function.args.kw_defaults)]
    shared = {name: value for statement in tree.body for name, value in _iter_assigned_names(statement)}
    waiting = {name for name, value in shared.items() if value is None or _is_fillable_container(value, own)}
    inside = [node for function in functions for node in ast.walk(function)]
    return (
        any(isinstance(node, ast.Global | ast.Nonlocal) for node in nodes)
        or any(isinstance(default, _MUTABLE) for default in defaults)
        or any(function.decorator_list for function in functions)
        or any(_sets_attribute(node, own) for node in nodes)
        or any(isinstance(node, ast.Name) and node.id in waiting for node in inside)
        or any(_mutated_name(node) in shared for node in inside)
    )


def _tuple_elements(value: ast.expr | None) -> list[ast.expr | None]:
    """Return the values of a tuple, or a value alone."""
    return [*value.elts] if isinstance(value, ast.Tuple) else [value]


def _iter_assigned_names(statement: ast.stmt) -> Iterator[tuple[str, ast.expr | None]]:
    """Yield the names of a top-level assignment, each with its value, None where it cannot be told apart."""
    if not isinstance(statement, ast.Assign | ast.AnnAssign):
        return
    for target in statement.targets if isinstance(statement, ast.Assign) else [statement.target]:
        if isinstance(target, ast.Name):
            yield target.id, statement.value
        elif isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple):
            pairs = zip(target.elts, statement.value.elts, strict=False)
            yield from ((name.id, value) for name, value in pairs if isinstance(name, ast.Name))


def _is_fillable_container(value: ast.expr, own: Collection[str]) -> bool:
    """Whether a value is an empty container, or is made by a class or a function that is not numpy's or math's."""
    match value:
        case ast.List(elts=items) | ast.Set(elts=items) | ast.Dict(keys=items):
            return not items
        case ast.Call(func=ast.Name(id=name)):
            return name in own or name in _CONTAINERS
        case ast.Call(func=ast.Attribute(attr=name)):
            return name in _CONTAINERS
    return False


def _mutated_name(node: ast.AST) -> str | None:
    """Return the name of what a node writes into: by an index, an augmented assignment or a method of containers."""
    match node:
        case ast.Subscript(value=ast.Name(id=name), ctx=ast.Store() | ast.Del()):
            return name
        case ast.AugAssign(target=ast.Name(id=name)):
            return name
        case ast.Call(func=ast.Attribute(value=ast.Name(id=name), attr=method)) if method in _WRITERS:
            return name
    return None


def _may_assign_read_name(statement: ast.Assign | ast.AnnAssign, read: AbstractSet[str]) -> bool:
    """Whether an assignment is to one of the names that are read, or to anything but names."""
    targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
    return any(not isinstance(target, ast.Name) or target.id in read for target in targets)


def _sets_attribute(node: ast.AST, names: Collection[str]) -> bool:
    return (
        isinstance(node, ast.Attribute)
        and isinstance(node.ctx, ast.Store)
        and isinstance(node.value, ast.Name)
        and node.value.id in names
    )


def _names_bound_by(statement: ast.stmt, shared: AbstractSet[str]) -> set[str] | None:
    """Return the names that a top-level statement binds; None where it may do something else."""
    match statement:
        case ast.FunctionDef():
            return {statement.name}
        case ast.Expr(value=ast.Constant()):
            return set()
        case ast.Import(names=names) if all(alias.name in _MODULES for alias in names):
            return {alias.asname or alias.name for alias in names}
        case ast.ImportFrom(module=module, names=names, level=0) if module in _MODULES:
            return (
                {alias.asname or alias.name for alias in names}
                if {alias.name for alias in names} <= _ATTRIBUTES
                else None
            )
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            return {name} if _is_harmless(value, shared, (), _CONSTANT) else None
    return None


def _is_harmless(
    tree: ast.AST, shared: AbstractSet[str], hidden: Collection[str], kinds: Collection[type] = _PARTS.keys()
) -> bool:
    """Whether a tree reads its own and the `shared` names only, and binds none of the `hidden` ones."""
    read, own = set[str](), set[str]()
    waiting: list[Any] = [tree]
    while waiting:
        node = waiting.pop()
        kind = type(node)
        if kind not in kinds or not _CHECKS.get(kind, _accept_any)(node):
            return False
        if kind is ast.Name:
            (read if type(node.ctx) is ast.Load else own).add(node.id)
        elif kind is ast.arg or kind is ast.FunctionDef:
            own.add(node.arg if kind is ast.arg else node.name)
        for name in _PARTS[kind]:
            part = getattr(node, name)
            if type(part) is list:
                waiting += [child for child in part if child is not None]
            elif part is not None:
                waiting.append(part)
    return own.isdisjoint(hidden) and read <= own | shared


def _accept_any(node: Any) -> bool:
    """No further condition."""
    return True


def _is_harmless_attribute(node: Any) -> bool:
    return node.attr in _ATTRIBUTES and isinstance(node.ctx, ast.Load)


def _is_harmless_keyword(node: Any) -> bool:
    return node.arg is not None and node.arg != _UNWRITTEN


def _is_harmless_function(node: Any) -> bool:
    """No decorator, which may keep the function; no mutable default, which all calls share."""
    defaults = (*node.args.defaults, *node.args.kw_defaults)
    return not getattr(node, "decorator_list", ()) and all(
        default is None or type(default) is ast.Constant for default in defaults
    )


def _is_harmless_comparison(node: Any) -> bool:
    """Identity is compared with None only."""
    pairs = zip(node.ops, node.comparators, strict=True)
    return all(_is_none(other) for sign, other in pairs if isinstance(sign, ast.Is | ast.IsNot))


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _is_harmless_annotation(node: Any) -> bool:
    return isinstance(node.target, ast.Name)


_CHECKS: dict[type, Callable[[Any], bool]] = {
    ast.Attribute: _is_harmless_attribute,
    ast.keyword: _is_harmless_keyword,
    ast.FunctionDef: _is_harmless_function,
    ast.Lambda: _is_harmless_function,
    ast.Compare: _is_harmless_comparison,
    ast.AnnAssign: _is_harmless_annotation,
}
