"""Parses what a student types for a run, without executing anything: « predire2d((0, 0, 0), 1, np.pi / 2) »."""

from __future__ import annotations

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from graders.core.syntax_trees import parse_expression
from graders.typography import limit_marks
from server.base.errors import Invalid
from server.base.validation import encode_bounded
from server.sandbox import Value
from server.sandbox.child.codec import ValueLimits, ValueTooBig, encode
from server.text.plain import show_invisible_characters

#: Maximum number of items written of an array, a list or a dictionary.
MAX_ITEMS_WRITTEN = 16
#: Bounds of arguments sent to the sandbox, checked here so that the refusal can explain itself.
_SENDABLE = ValueLimits(size=1 << 26, depth=32, items=1 << 20)
#: Bounds of a call: characters, syntax nodes, items of an array created by shape, digits of a number.
MAX_CHARACTERS, MAX_NODES, MAX_ARRAY_ITEMS, MAX_DIGITS = 4000, 2000, 10_000, 300

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
_ARRAY_FACTORIES: Mapping[str, Callable[..., Any]] = {"zeros": np.zeros, "ones": np.ones, "eye": np.eye}
_HOW = "Écrivez-le comme dans Python, valeurs comprises : par exemple « composer((1, 2, 0), (1, 0, pi / 2)) »."


_VALUES = "Écrivez un nombre ou une liste, comme dans Python : 1.5, pi/2, [0, 1, 2]."


@dataclass(frozen=True)
class TypedCall:
    """A parsed call: function, positional and keyword arguments."""

    function: str
    arguments: tuple[Value, ...]
    named: Mapping[str, Value]


def parse_call(typed: str) -> TypedCall:
    """Parse a call. Raises Invalid, with the part that is not understood."""
    if len(typed) > MAX_CHARACTERS:
        raise Invalid(f"Cet appel est trop long : {MAX_CHARACTERS} caractères au plus.")
    call = _parse_expression(typed.strip())
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name):
        raise Invalid(f"Ce n’est pas l’appel d’une fonction de votre programme. {_HOW}")
    if sum(1 for _ in ast.walk(call)) > MAX_NODES:
        raise Invalid("Cet appel a trop de valeurs pour être suivi pas à pas.")
    try:
        named: dict[str, Value] = {}
        for keyword in call.keywords:
            if (name := _require_keyword_name(keyword)) in named:
                raise Invalid(f"L’argument {name} est donné deux fois.")
            named[name] = _evaluate_literal(keyword.value)
        read = TypedCall(call.func.id, tuple(map(_evaluate_literal, call.args)), named)
        encode((read.arguments, named), _SENDABLE)
    except (RecursionError, ValueTooBig) as error:
        raise Invalid("Cet appel est imbriqué trop profondément pour être suivi pas à pas.") from error
    return read


def parse_value(typed: str) -> Value:
    """Parse one value, « [1, 2, pi/2] ». Raises Invalid, with the part that is not understood or where it is."""
    words = typed.strip()
    if len(words) > MAX_CHARACTERS:
        raise Invalid(f"Cette valeur est trop longue : {MAX_CHARACTERS} caractères au plus.")
    try:
        node = parse_expression(words).body
    except SyntaxError as error:
        raise Invalid(_describe_syntax_break(words, error)) from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise Invalid(f"Python ne comprend pas cette valeur. {_VALUES}") from error
    if sum(1 for _ in ast.walk(node)) > MAX_NODES:
        raise Invalid("Cette valeur a trop de parties.")
    try:
        return _evaluate_literal(node)
    except RecursionError as error:
        raise Invalid("Cette valeur est imbriquée trop profondément.") from error
    except Invalid as error:
        raise Invalid(error.detail.replace(_HOW, _VALUES).replace("dans un appel", "ici")) from error


def parse_stdin_lines(typed: str) -> tuple[str, ...]:
    """Return the lines of a standard input; a newline at its end begins no line. Raises Invalid or TooLarge."""
    text = encode_bounded(typed, 4 * MAX_CHARACTERS, "L’entrée standard").decode().replace("\r\n", "\n")
    return tuple(text.removesuffix("\n").split("\n")) if text else ()


def _describe_syntax_break(typed: str, error: SyntaxError) -> str:
    """Say where a value stops being Python."""
    opened = len(re.findall(r"[\[(]", typed)) - len(re.findall(r"[\])]", typed))
    if opened > 0:
        return f"il manque un crochet ou une parenthèse à la fin. {_VALUES}"
    if opened < 0:
        return f"il y a un crochet ou une parenthèse de trop à la fin. {_VALUES}"
    place = max(1, error.offset or 1)
    rest = show_invisible_characters(typed[place - 1 :][:20])
    return f"Python ne comprend pas la suite à partir du caractère {place}, « {rest} ». {_VALUES}"


def format_call(call: TypedCall) -> str:
    """Write the call as text, large values by their shapes."""
    named = (f"{name}={_format_value(value)}" for name, value in call.named.items())
    return f"{call.function}({', '.join([*map(_format_value, call.arguments), *named])})"


def _format_value(value: Value) -> str:
    if isinstance(value, np.ndarray):
        shape = " × ".join(map(str, value.shape))
        return f"np.array({_format_value(value.tolist())})" if value.size <= MAX_ITEMS_WRITTEN else f"[tableau {shape}]"
    if isinstance(value, tuple | list):
        items = ", ".join(map(_format_value, value[:MAX_ITEMS_WRITTEN]))
        items = (
            f"{items}, …"
            if len(value) > MAX_ITEMS_WRITTEN
            else f"{items},"
            if type(value) is tuple and len(value) == 1
            else items
        )
        return f"({items})" if isinstance(value, tuple) else f"[{items}]"
    if isinstance(value, dict):
        pairs = ", ".join(f"{key!r}: {_format_value(item)}" for key, item in [*value.items()][:MAX_ITEMS_WRITTEN])
        return f"{{{pairs}{', …' * (len(value) > MAX_ITEMS_WRITTEN)}}}"
    return show_invisible_characters(repr(value))


def _parse_expression(typed: str) -> ast.expr:
    if typed != limit_marks(typed):
        raise Invalid("Une lettre de cet appel porte trop d’accents l’un sur l’autre : retapez-la au clavier.")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what is typed, a warning concerns nobody
            return parse_expression(typed).body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise Invalid(f"Python ne comprend pas cet appel. {_HOW}") from error


def _require_keyword_name(keyword: ast.keyword) -> str:
    if keyword.arg is None:
        raise Invalid("« ** » n’a pas de sens ici : écrivez chaque argument.")
    return keyword.arg


def _evaluate_literal(node: ast.expr) -> Value:
    """Evaluate a literal, simple arithmetic, a constant or an array constructor."""
    value: Value
    match node:
        case ast.Constant():
            value = _evaluate_constant(node)
        case ast.List(items):
            value = [_evaluate_literal(item) for item in items]
        case ast.Tuple(items):
            value = tuple(map(_evaluate_literal, items))
        case ast.Dict(keys, items):
            value = {_require_text_key(key): _evaluate_literal(item) for key, item in zip(keys, items, strict=True)}
        case ast.UnaryOp() | ast.BinOp():
            value = _evaluate_arithmetic(node)
        case ast.Name() | ast.Attribute():
            value = _evaluate_name(node)
        case ast.Call():
            value = _evaluate_array(node)
        case _:
            raise _not_understood_error(node)
    return value


def _evaluate_constant(node: ast.Constant) -> Value:
    value = node.value
    if isinstance(value, str) or value is None:
        return value
    if not isinstance(value, _NUMBERS):
        raise _not_understood_error(node)
    return _require_few_digits(value)


def _require_text_key(node: ast.expr | None) -> str:
    if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
        raise Invalid('Les clés d’un dictionnaire sont des textes : { "a": 1 }.')
    return node.value


def _evaluate_arithmetic(node: ast.UnaryOp | ast.BinOp) -> Value:
    """Evaluate simple arithmetic of numbers."""
    try:
        if isinstance(node, ast.UnaryOp) and type(node.op) in _SIGNS:
            return _require_few_digits(_SIGNS[type(node.op)](_evaluate_number(node.operand)))
        if isinstance(node, ast.BinOp) and type(node.op) in _SUMS:
            return _require_few_digits(_SUMS[type(node.op)](_evaluate_number(node.left), _evaluate_number(node.right)))
    except (ArithmeticError, ValueError) as error:
        raise Invalid(f"Ce calcul est impossible : « {_source_excerpt(node)} ».") from error
    raise _not_understood_error(node)


def _evaluate_number(node: ast.expr) -> Number:
    value = _evaluate_literal(node)
    if not isinstance(value, _NUMBERS):
        raise Invalid(f"On ne calcule ici qu’avec des nombres : « {_source_excerpt(node)} » n’en est pas un.")
    return value


def _require_few_digits(value: Number) -> Number:
    if isinstance(value, int) and abs(value) >= 10**MAX_DIGITS:
        raise Invalid(f"Un nombre de plus de {MAX_DIGITS} chiffres ne se suit pas pas à pas.")
    return value


def _evaluate_name(node: ast.Name | ast.Attribute) -> float:
    """Evaluate pi, np.pi, math.inf…"""
    if isinstance(node, ast.Attribute):
        module = node.value
        is_known = isinstance(module, ast.Name) and module.id in _MODULES
        name = node.attr if is_known else ""
    else:
        name = node.id if node.id != "e" else ""
    if name not in _NAMES:
        raise Invalid(f"« {_source_excerpt(node)} » n’est pas connu ici : écrivez sa valeur.")
    return _NAMES[name]


def _evaluate_array(node: ast.Call) -> Value:
    """Evaluate np.array([…]), np.zeros(3), np.ones((2, 3)), np.eye(2)."""
    constructor = node.func
    if not (
        isinstance(constructor, ast.Attribute)
        and isinstance(constructor.value, ast.Name)
        and constructor.value.id in _MODULES
    ):
        raise _not_understood_error(node)
    if len(node.args) != 1 or node.keywords:
        raise Invalid(f"Un seul argument est compris ici : « {_source_excerpt(node)} ».")
    argument = _evaluate_literal(node.args[0])
    if constructor.attr in ("array", "asarray"):
        return _build_numeric_array(argument, node)
    if constructor.attr in _ARRAY_FACTORIES and _is_shape(argument, flat=constructor.attr == "eye"):
        filled: Value = _ARRAY_FACTORIES[constructor.attr](argument)
        return filled
    raise _not_understood_error(node)


def _build_numeric_array(argument: Value, node: ast.expr) -> Value:
    try:
        array = np.array(argument)
    except (ValueError, OverflowError) as error:
        raise Invalid(
            f"Les lignes de ce tableau n’ont pas toutes la même longueur : « {_source_excerpt(node)} »."
        ) from error
    if array.dtype.kind not in "biufc":
        raise Invalid(f"Un tableau ne tient ici que des nombres : « {_source_excerpt(node)} ».")
    return array


def _is_shape(argument: Value, *, flat: bool) -> bool:
    sides = argument if isinstance(argument, tuple | list) and not flat else (argument,)
    if not all(type(side) is int and 0 <= side <= MAX_ARRAY_ITEMS for side in sides) or len(sides) > 4:
        return False
    items = math.prod(side for side in sides if type(side) is int)
    return (items * items if flat else items) <= MAX_ARRAY_ITEMS


def _not_understood_error(node: ast.AST) -> Invalid:
    return Invalid(f"Ceci n’est pas compris dans un appel : « {_source_excerpt(node)} ». {_HOW}")


def _source_excerpt(node: ast.AST) -> str:
    """Return the beginning of the typed expression."""
    text = ast.unparse(node)
    return text if len(text) <= 60 else f"{text[:59]}…"
