"""Values that a reader types for the arguments of a hunted function, and how they are written for the reader."""

import re
from collections.abc import Mapping

import numpy as np

from graders.core.code.hunts import InputFault
from graders.core.compare.words import fraction_of_pi
from graders.core.contract.values import Value
from server.base.errors import Invalid
from server.steps import calls


def parse_typed_arguments(typed: Mapping[str, str]) -> dict[str, Value]:
    """Read typed arguments; those left empty are not given. Raises InputFault."""
    return {name: parse_typed_value(name, words) for name, words in typed.items() if words.strip()}


def parse_typed_value(name: str, typed: str) -> Value:
    """Read the value typed for the argument `name`. Raises InputFault."""
    try:
        return calls.parse_value(typed)
    except Invalid as error:
        raise InputFault(name, f"{name} : {error}") from error


def format_typed_argument(value: Value) -> str:
    """Return a number or a list of numbers as a reader types it: « [0, 1, pi/2] »."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(format_typed_argument, value))}]"
    if isinstance(value, np.ndarray):
        return format_typed_argument(value.tolist())
    number = float(value)
    if number == int(number):
        return str(int(number))
    part = fraction_of_pi(number)
    if part is None:
        return f"{number:.6g}"
    return re.sub(r"(?<=\d)π", "*π", part).replace("π", "pi").replace("−", "-")
