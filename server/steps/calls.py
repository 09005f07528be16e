"""A call as somebody types it, « predire2d((0, 0, 0), 1, np.pi / 2) », read without running anything."""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from server.base.errors import Invalid
from server.sandbox import Value
from server.sandbox.child.codec import ValueLimits, ValueTooBig, encode
from server.text.plain import visible

#: Values that are written of an array, a list, a dictionary.
SHOWN = 16
#: What goes to the sandbox: more is refused here, where it can be said.
_SENDABLE = ValueLimits(size=1 << 26, depth=32, items=1 << 20)
#: Characters of a call, parts of it, items of an array made by its shape, digits of a number.
LONGEST, PARTS, ITEMS, DIGITS = 4000, 2000, 10_000, 300

Number: TypeAlias = "bool | int | float | complex"
_NUMBERS = (bool, int, float, complex)
_NAMES: Mapping[str, float] = {"pi": math.pi, "inf": math.inf, "nan": math.nan, "tau": math.tau, "e": math.e}
_MODULES = frozenset({"np", "numpy", "math"})
_SIGNS: Mapping[type, Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos}
_SUMS: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_FILLED: Mapping[str, Callable[..., Any]] = {"zeros": np.zeros, "ones": np.ones, "eye": np.eye}
_HOW = "Écrivez-le comme dans Python, valeurs comprises : par exemple « composer((1, 2, 0), (1, 0, pi / 2)) »."


@dataclass(frozen=True)
class Call:
    """What is called with what."""

    function: str
    arguments: tuple[Value, ...]
    named: Mapping[str, Value]


def read(typed: str) -> Call:
    """Raises Invalid, with what is not understood."""
    if len(typed) > LONGEST:
        raise Invalid(f"Cet appel est trop long : {LONGEST} caractères au plus.")
    call = _parsed(typed.strip())
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name):
        raise Invalid(f"Ce n’est pas l’appel d’une fonction de votre programme. {_HOW}")
    if sum(1 for _ in ast.walk(call)) > PARTS:
        raise Invalid("Cet appel a trop de valeurs pour être suivi pas à pas.")
    try:
        named: dict[str, Value] = {}
        for one in call.keywords:
            if (name := _name(one)) in named:
                raise Invalid(f"L’argument {name} est donné deux fois.")
            named[name] = _value(one.value)
        read = Call(call.func.id, tuple(map(_value, call.args)), named)
        encode((read.arguments, named), _SENDABLE)
    except (RecursionError, ValueTooBig) as error:
        raise Invalid("Cet appel est imbriqué trop profondément pour être suivi pas à pas.") from error
    return read


def written(call: Call) -> str:
    """The call in words of ours, its large values by their shapes."""
    named = (f"{name}={_written(value)}" for name, value in call.named.items())
    return f"{call.function}({', '.join([*map(_written, call.arguments), *named])})"


def _written(value: Value) -> str:
    if isinstance(value, np.ndarray):
        shape = " × ".join(map(str, value.shape))
        return f"np.array({_written(value.tolist())})" if value.size <= SHOWN else f"[tableau {shape}]"
    if isinstance(value, tuple | list):
        items = ", ".join(map(_written, value[:SHOWN]))
        items = (
            f"{items}, …" if len(value) > SHOWN else f"{items}," if type(value) is tuple and len(value) == 1 else items
        )
        return f"({items})" if isinstance(value, tuple) else f"[{items}]"
    if isinstance(value, dict):
        pairs = ", ".join(f"{key!r}: {_written(one)}" for key, one in [*value.items()][:SHOWN])
        return f"{{{pairs}{', …' * (len(value) > SHOWN)}}}"
    return visible(repr(value))


def _parsed(typed: str) -> ast.expr:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what is typed, a warning concerns nobody
            return ast.parse(typed, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise Invalid(f"Python ne comprend pas cet appel. {_HOW}") from error


def _name(keyword: ast.keyword) -> str:
    if keyword.arg is None:
        raise Invalid("« ** » n’a pas de sens ici : écrivez chaque argument.")
    return keyword.arg


def _value(node: ast.expr) -> Value:
    """The value of a literal, or of a little more than that."""
    value: Value
    match node:
        case ast.Constant():
            value = _constant(node)
        case ast.List(items):
            value = [_value(item) for item in items]
        case ast.Tuple(items):
            value = tuple(map(_value, items))
        case ast.Dict(keys, items):
            value = {_key(key): _value(item) for key, item in zip(keys, items, strict=True)}
        case ast.UnaryOp() | ast.BinOp():
            value = _computed(node)
        case ast.Name() | ast.Attribute():
            value = _named(node)
        case ast.Call():
            value = _array(node)
        case _:
            raise _unknown(node)
    return value


def _constant(node: ast.Constant) -> Value:
    value = node.value
    if isinstance(value, str) or value is None:
        return value
    if not isinstance(value, _NUMBERS):
        raise _unknown(node)
    return _bounded(value)


def _key(node: ast.expr | None) -> str:
    if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
        raise Invalid('Les clés d’un dictionnaire sont des textes : { "a": 1 }.')
    return node.value


def _computed(node: ast.UnaryOp | ast.BinOp) -> Value:
    """Simple arithmetic of numbers."""
    try:
        if isinstance(node, ast.UnaryOp) and type(node.op) in _SIGNS:
            return _bounded(_SIGNS[type(node.op)](_number(node.operand)))
        if isinstance(node, ast.BinOp) and type(node.op) in _SUMS:
            return _bounded(_SUMS[type(node.op)](_number(node.left), _number(node.right)))
    except (ArithmeticError, ValueError) as error:
        raise Invalid(f"Ce calcul est impossible : « {_text(node)} ».") from error
    raise _unknown(node)


def _number(node: ast.expr) -> Number:
    value = _value(node)
    if not isinstance(value, _NUMBERS):
        raise Invalid(f"On ne calcule ici qu’avec des nombres : « {_text(node)} » n’en est pas un.")
    return value


def _bounded(value: Number) -> Number:
    if isinstance(value, int) and abs(value) >= 10**DIGITS:
        raise Invalid(f"Un nombre de plus de {DIGITS} chiffres ne se suit pas pas à pas.")
    return value


def _named(node: ast.Name | ast.Attribute) -> float:
    """pi, np.pi, math.inf…"""
    if isinstance(node, ast.Attribute):
        module = node.value
        known = isinstance(module, ast.Name) and module.id in _MODULES
        name = node.attr if known else ""
    else:
        name = node.id if node.id != "e" else ""
    if name not in _NAMES:
        raise Invalid(f"« {_text(node)} » n’est pas connu ici : écrivez sa valeur.")
    return _NAMES[name]


def _array(node: ast.Call) -> Value:
    """np.array([…]), np.zeros(3), np.ones((2, 3)), np.eye(2)."""
    made = node.func
    if not (isinstance(made, ast.Attribute) and isinstance(made.value, ast.Name) and made.value.id in _MODULES):
        raise _unknown(node)
    if len(node.args) != 1 or node.keywords:
        raise Invalid(f"Un seul argument est compris ici : « {_text(node)} ».")
    given = _value(node.args[0])
    if made.attr in ("array", "asarray"):
        return _numbers(given, node)
    if made.attr in _FILLED and _is_shape(given, flat=made.attr == "eye"):
        filled: Value = _FILLED[made.attr](given)
        return filled
    raise _unknown(node)


def _numbers(given: Value, node: ast.expr) -> Value:
    try:
        array = np.array(given)
    except (ValueError, OverflowError) as error:
        raise Invalid(f"Les lignes de ce tableau n’ont pas toutes la même longueur : « {_text(node)} ».") from error
    if array.dtype.kind not in "biufc":
        raise Invalid(f"Un tableau ne tient ici que des nombres : « {_text(node)} ».")
    return array


def _is_shape(given: Value, *, flat: bool) -> bool:
    sides = given if isinstance(given, tuple | list) and not flat else (given,)
    if not all(type(side) is int and 0 <= side <= ITEMS for side in sides) or len(sides) > 4:
        return False
    items = math.prod(side for side in sides if type(side) is int)
    return (items * items if flat else items) <= ITEMS


def _unknown(node: ast.AST) -> Invalid:
    return Invalid(f"Ceci n’est pas compris dans un appel : « {_text(node)} ». {_HOW}")


def _text(node: ast.AST) -> str:
    """The beginning of what was typed there."""
    text = ast.unparse(node)
    return text if len(text) <= 60 else f"{text[:59]}…"
