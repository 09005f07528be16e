"""Strict reading of a JSON object: nothing missing, nothing unknown, nothing of another type."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self, TypeVar

T = TypeVar("T")


class MalformedVerdictError(Exception):
    """JSON that is not a verdict: where (`place`, "checks/0/points"; empty for the whole) and why (`reason`)."""

    def __init__(self, place: str, reason: str) -> None:
        super().__init__(f"{place or 'the verdict'}: {reason}")
        self.place, self.reason = place, reason


class ObjectReader:
    """The members of one JSON object, each taken once; at the end of the block, one that is left raises.

    Every reader raises MalformedVerdictError for a member that is missing or not of its type.
    """

    def __init__(self, value: Any, place: str = "") -> None:
        if not isinstance(value, dict):
            raise MalformedVerdictError(place, f"is {_type_text(value)}, not an object")
        self._left = dict(value)
        self._place = place

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        if error is None and self._left:
            raise MalformedVerdictError(self.place_of(str(min(self._left, key=str))), "is not expected")

    def place_of(self, name: str) -> str:
        return f"{self._place}/{name}" if self._place else name

    def has_member(self, name: str) -> bool:
        """Whether an optional member is present."""
        return name in self._left

    def read_any(self, name: str) -> Any:
        """Take a member of any strict JSON."""
        return _check_strict_json(self._take_member(name), self.place_of(name))

    def read_text(self, name: str) -> str:
        return str(self._take_typed_member(name, (str,), "a text"))

    def read_texts(self, name: str) -> tuple[str, ...]:
        return self.read_items(name, _check_text)

    def read_flag(self, name: str) -> bool:
        return bool(self._take_typed_member(name, (bool,), "true or false"))

    def read_whole_number(self, name: str) -> int:
        return int(self._take_typed_member(name, (int,), "a whole number"))

    def read_number(self, name: str) -> float:
        """A finite number, kept as it is written: 4 stays 4, and 4.0 stays 4.0."""
        value: float = self._take_typed_member(name, (int, float), "a number")
        if not math.isfinite(value):
            raise MalformedVerdictError(self.place_of(name), "is not finite")
        return value

    def read_items(self, name: str, read: Callable[[Any, str], T]) -> tuple[T, ...]:
        """A list, each item read with its place."""
        items = self._take_typed_member(name, (list,), "a list")
        return tuple(read(item, f"{self.place_of(name)}/{index}") for index, item in enumerate(items))

    def read_numbers(self, name: str) -> dict[str, float]:
        """An object whose members are all numbers."""
        value = self._take_member(name)
        with ObjectReader(value, self.place_of(name)) as members:
            return {key: members.read_number(key) for key in value}

    def read_object(self, name: str) -> dict[str, Any]:
        """An object of strict JSON."""
        return dict(_check_strict_json(self._take_typed_member(name, (dict,), "an object"), self.place_of(name)))

    def read_optional(self, name: str, read: Callable[[Any, str], T]) -> T | None:
        """null, or what `read` makes of the value and its place."""
        value = self._take_member(name)
        return None if value is None else read(value, self.place_of(name))

    def read_optional_text(self, name: str) -> str | None:
        return self.read_optional(name, _check_text)

    def _take_member(self, name: str) -> Any:
        if name not in self._left:
            raise MalformedVerdictError(self.place_of(name), "is missing")
        return self._left.pop(name)

    def _take_typed_member(self, name: str, types: tuple[type, ...], wanted: str) -> Any:
        value = self._take_member(name)
        if type(value) not in types:
            raise MalformedVerdictError(self.place_of(name), f"is {_type_text(value)}, not {wanted}")
        return value


def _check_text(value: Any, place: str) -> str:
    if type(value) is not str:
        raise MalformedVerdictError(place, f"is {_type_text(value)}, not a text")
    return value


def _check_strict_json(value: Any, place: str) -> Any:
    """Return the value, once checked to be strict JSON."""
    if isinstance(value, list):
        for index, item in enumerate(value):
            _check_strict_json(item, f"{place}/{index}")
    elif isinstance(value, dict):
        for key, item in value.items():
            _check_strict_json(item, f"{place}/{_check_text(key, place)}")
    elif value is not None and (
        type(value) not in (bool, int, float, str) or (isinstance(value, float) and not math.isfinite(value))
    ):
        raise MalformedVerdictError(place, f"is {_type_text(value)}, which JSON does not hold")
    return value


def _type_text(value: Any) -> str:
    return "null" if value is None else f"of type {type(value).__name__}"
