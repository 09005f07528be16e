"""Calls of the course's functions: a program asks, a process of its own that holds the functions answers.

A program has nothing of such a function but its name. Arguments and results cross as plain values: an instance of a
subclass, a callback or an array with methods of its own arrives as the value of its base type, or not at all.
"""

from __future__ import annotations

import builtins
from collections.abc import Callable, Collection, Iterable, Mapping
from types import ModuleType
from typing import Any

import numpy as np

from .codec import MalformedValue, UnsendableValue, Value, ValueTooBig
from .frames import ASK_LIMITS
from .small_values import decode, encode

#: Calls a function of the course, given its name, its arguments and its named arguments.
Ask = Callable[[str, tuple[object, ...], Mapping[str, object]], object]
#: First item of a reply.
VALUE, SCALAR, RAISED, EXPIRED = "value", "scalar", "raised", "expired"
_MAX_TEXT = 600


class TimeExpired(BaseException):
    """The process that holds the functions has used up its processor time."""


def make_stub(name: str, filename: str, ask: Ask) -> Callable[..., object]:
    """Return a function that asks for a call of the function `name`; its code is said to be in `filename`."""

    def course_function(*args: object, **named: object) -> object:
        return ask(name, args, named)

    course_function.__name__ = course_function.__qualname__ = name
    course_function.__module__ = filename.partition("/")[0]
    course_function.__doc__ = "Fonction du cours : elle se calcule hors de votre programme."
    course_function.__code__ = course_function.__code__.replace(co_filename=filename, co_name=name)
    return course_function


def encode_call(name: str, arguments: tuple[object, ...], named: Mapping[str, object]) -> bytes:
    """Encode a call. Raises TypeError for an argument that is no value, ValueError for one that is too big."""
    try:
        try:
            return encode((name, arguments, dict(named)), ASK_LIMITS)
        except UnsendableValue:
            return encode(
                (name, _replace_iterables_by_lists(arguments), _replace_iterables_by_lists(dict(named))), ASK_LIMITS
            )
    except UnsendableValue as error:
        raise TypeError(f"{name}() cannot take an object of type '{error.culprit}'") from None
    except ValueTooBig:
        raise ValueError(f"{name}(): arguments too big") from None


def _replace_iterables_by_lists(value: Any) -> Any:
    """Replace iterables that are no values (sets, generators, queues…) by lists."""
    if isinstance(value, (str, bytes, int, float, complex, np.ndarray, np.generic)) or value is None:
        return value
    if isinstance(value, dict):
        return {key: _replace_iterables_by_lists(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return tuple(map(_replace_iterables_by_lists, value))
    if isinstance(value, Iterable) and not hasattr(type(value), "__array__") and not hasattr(value, "toarray"):
        return [_replace_iterables_by_lists(item) for item in value]
    return value


def read_reply(reply: bytes) -> object:
    """Return the value of a reply, or raise the exception that the call raised; TimeExpired where time is up."""
    kind, *rest = _as_tuple(decode(reply, ASK_LIMITS))
    if kind == VALUE:
        return rest[0]
    if kind == SCALAR:
        return rest[0][0]
    if kind == EXPIRED:
        raise TimeExpired
    raise _build_exception(*rest)


def _as_tuple(value: Any) -> tuple[Any, ...]:
    return tuple(value)


def _build_exception(name: str, arguments: tuple[Value, ...], text: str) -> Exception:
    """Return the exception of this name; one of a type made for it where Python has none that says the same."""
    kind: Any = np.linalg.LinAlgError if name == "LinAlgError" else getattr(builtins, name, None)
    if isinstance(kind, type) and issubclass(kind, Exception):
        try:
            error: Exception = kind(*arguments)
        except TypeError:  # it wants other arguments
            return RuntimeError(text)
        if str(error) == text:
            return error
    made: Exception = type(name, (Exception,), {})(text)
    return made


def encode_raised(error: BaseException) -> bytes:
    """Encode the exception that a function of the course raised: its type's name, its arguments and its text."""
    name = "MemoryError" if isinstance(error, MemoryError) else type(error).__name__
    text = str(error)[:_MAX_TEXT]
    try:
        return encode((RAISED, name, error.args, text), ASK_LIMITS)
    except (UnsendableValue, ValueTooBig):
        return encode((RAISED, name, (text,), text), ASK_LIMITS)


def answer_call(question: bytes, functions: ModuleType, offered: Collection[str]) -> bytes:
    """Call a function for a program and return the reply; the question may be hostile.

    Raises whatever keeps a function of the course from being there at all: that is our own fault.
    """
    try:
        name, arguments, named = _parse_call(question)
    except MalformedValue:
        return encode_raised(TypeError("this is no call"))
    if name not in offered:
        return encode_raised(AttributeError(f"module has no attribute '{name}'"))
    function = getattr(functions, name)
    try:
        value = function(*arguments, **named)
        if isinstance(value, np.generic):
            return encode((SCALAR, np.asarray(value).reshape(1)), ASK_LIMITS)
        return encode((VALUE, value), ASK_LIMITS)
    except Exception as error:
        return encode_raised(error)


def _parse_call(question: bytes) -> tuple[str, tuple[Any, ...], dict[str, Any]]:
    match decode(question, ASK_LIMITS):
        case (str() as name, tuple() as arguments, dict() as named):
            return name, arguments, named
    raise MalformedValue("no call")


#: Reply to a call after one that was cut short, so that nobody takes an earlier reply for its own.
INTERRUPTED = encode_raised(RuntimeError("mes_fonctions : un appel a été interrompu"))
