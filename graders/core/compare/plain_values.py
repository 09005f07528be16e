"""Comparison of any plain values: texts, dictionaries, sets, booleans, lists in any order, exceptions.

`SamePlainValue` is for packaged and declared exercises alike. Numbers agree within a tolerance; a list, a tuple and an
array of the same items agree, unless the types are strict.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from graders.core.compare.comparison import TOLERANCE, Mismatch
from graders.core.compare.python_values import OpaqueObject, RaisedException, python_text, python_text_pair
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Value

Order = Literal["same", "any", "set"]
#: Items of which two lists are matched one by one, in any order; longer ones are sorted.
MAX_MATCHED = 200
#: Items named in a sentence.
NAMED = 5


@dataclass(frozen=True)
class SamePlainValue:
    """Equal plain values.

    Numbers agree within `tolerance`, relative beyond 1 and absolute below, or always `absolute`. With `order` "any",
    the items of a list may come in any order; with "set", repeated items count once too. With `strict`, a tuple is no
    list and 1.0 no integer. With `spaces` false, spaces and capitals of a text do not count.
    """

    tolerance: float = TOLERANCE
    absolute: bool = False
    order: Order = "same"
    strict: bool = False
    spaces: bool = True

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        expected, got = _without_numpy_types(expected), _without_numpy_types(got)
        if isinstance(got, OpaqueObject):
            return Mismatch(f"On attend {nature_text(expected)}, pas un objet {got}.", cause=Outcome.INVALID_OUTPUT)
        sentence = self._find_difference(expected, got)
        return None if sentence is None else Mismatch(sentence, _find_slip(expected, got))

    def _find_difference(self, expected: Value, got: Value) -> str | None:
        if self.order != "same" and _is_sequence(expected) and _is_sequence(got):
            return self._unordered_difference(list(expected), list(got))
        return self._find_nested_difference(expected, got, "")

    def _find_nested_difference(self, expected: Value, got: Value, path: str) -> str | None:
        """Return why two values differ, the place first; None where they agree."""
        comparison = self._choose_comparison(expected, got)
        if comparison is not None:
            return comparison(expected, got, path)
        if type(expected) is not type(got):
            return _wrong_nature_sentence(expected, got, path)
        return None if expected == got else _value_difference_sentence(expected, got, path)

    def _choose_comparison(self, expected: Value, got: Value) -> Callable[[Any, Any, str], str | None] | None:
        """Return the comparison of two values of the same nature; None where only equality tells."""
        alike = type(expected) is type(got) or not self.strict
        comparisons: tuple[tuple[Callable[[Value], bool], bool, Callable[[Any, Any, str], str | None]], ...] = (
            (_is_dict, True, self._dict_difference),
            (_is_set, True, self._set_difference),
            (_is_sequence, alike, self._sequence_difference),
            (_is_number, alike, self._number_difference),
            (_is_text, type(expected) is type(got), self._text_difference),
        )
        return next((made for of, fits, made in comparisons if fits and of(expected) and of(got)), None)

    def _number_difference(self, expected: complex, got: complex, path: str) -> str | None:
        return None if self._are_close(expected, got) else _value_difference_sentence(expected, got, path)

    def _set_difference(self, expected: set[Value], got: set[Value], path: str) -> str | None:
        return self._unordered_difference(list(expected), list(got))

    def _are_close(self, expected: complex, got: complex) -> bool:
        if isinstance(expected, int) and isinstance(got, int):
            return expected == got
        if got != got or expected != expected:  # noqa: PLR0124
            return got != got and expected != expected  # noqa: PLR0124
        try:
            scale = 1.0 if self.absolute else max(1.0, abs(expected))
            return bool(got == expected or abs(got - expected) <= self.tolerance * scale)
        except OverflowError:  # integers beyond every float
            return False

    def _text_difference(self, expected: str, got: str, path: str) -> str | None:
        if expected == got or (not self.spaces and _without_spaces_and_case(expected) == _without_spaces_and_case(got)):
            return None
        if isinstance(expected, RaisedException):
            return f"On attend l’exception {expected}, et c’est {got} qui est levée."
        if _without_spaces_and_case(expected) == _without_spaces_and_case(got):
            return f"{_place_text(path)}Seuls les espaces ou les majuscules diffèrent : {_pair_text(expected, got)}."
        return _value_difference_sentence(expected, got, path)

    def _sequence_difference(self, expected: Sequence[Value], got: Sequence[Value], path: str) -> str | None:
        if len(expected) != len(got):
            return f"{_place_text(path)}{_item_count_text(len(got))} au lieu de {len(expected)}."
        differences = (
            self._find_nested_difference(wanted, obtained, f"{path}[{index}]")
            for index, (wanted, obtained) in enumerate(zip(expected, got, strict=True))
        )
        first = next((difference for difference in differences if difference), None)
        if first and not path and self._unordered_difference(list(expected), list(got)) is None:
            return "Les bons éléments y sont, mais pas dans le bon ordre."
        return first

    def _dict_difference(self, expected: dict[Any, Value], got: dict[Any, Value], path: str) -> str | None:
        missing = [key for key in expected if key not in got]
        extra = [key for key in got if key not in expected]
        if missing or extra:
            return _place_text(path) + _join_into_sentence(
                _missing_items_text("clé", missing), _extra_items_text("clé", extra)
            )
        differences = (
            self._find_nested_difference(expected[key], got[key], f"{path}[{python_text(key)}]") for key in expected
        )
        return next((difference for difference in differences if difference), None)

    def _unordered_difference(self, expected: list[Value], got: list[Value]) -> str | None:
        missing, extra = self._find_unmatched_items(expected, got)
        if self.order == "set" or not (missing or extra):
            missing = [item for item in missing if not self._is_among(item, got)]
            extra = [item for item in extra if not self._is_among(item, expected)]
        if not missing and not extra:
            return None
        return _join_into_sentence(_missing_items_text("élément", missing), _extra_items_text("élément", extra))

    def _find_unmatched_items(self, expected: list[Value], got: list[Value]) -> tuple[list[Value], list[Value]]:
        """Return the items of each list without a counterpart in the other."""
        if max(len(expected), len(got)) > MAX_MATCHED:
            wanted, obtained = sorted(expected, key=python_text), sorted(got, key=python_text)
            same = len(wanted) == len(obtained) and self._find_nested_difference(wanted, obtained, "[]") is None
            return ([], []) if same else (wanted[:NAMED], obtained[:NAMED])
        left, missing = list(got), []
        for item in expected:
            at = next(
                (k for k, other in enumerate(left) if self._find_nested_difference(item, other, "[]") is None), None
            )
            if at is None:
                missing.append(item)
            else:
                del left[at]
        return missing, left

    def _is_among(self, item: Value, items: Iterable[Value]) -> bool:
        return any(self._find_nested_difference(item, other, "[]") is None for other in items)


def nature_text(value: Value) -> str:
    """Return what kind of value this is, in French with its article: « une liste », « un texte »."""
    if isinstance(value, RaisedException):
        return f"l’exception {value}"
    if value is None:
        return "None"
    names: tuple[tuple[type | tuple[type, ...], str], ...] = (
        (bool, "un booléen"), (int, "un entier"), (float, "un nombre"), (complex, "un complexe"), (str, "un texte"),
        (bytes, "des octets"), (list, "une liste"), (tuple, "un n-uplet"), (dict, "un dictionnaire"),
        ((set, frozenset), "un ensemble"), (np.ndarray, "un tableau"),
    )  # fmt: skip
    return next((name for kind, name in names if isinstance(value, kind)), f"un objet {type(value).__name__}")


def _without_numpy_types(value: Value) -> Value:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, list | tuple):
        return type(value)(map(_without_numpy_types, value))
    return {key: _without_numpy_types(item) for key, item in value.items()} if isinstance(value, dict) else value


def _is_dict(value: Value) -> bool:
    return isinstance(value, dict)


def _is_set(value: Value) -> bool:
    return isinstance(value, set | frozenset)


def _is_text(value: Value) -> bool:
    return isinstance(value, str)


def _is_sequence(value: Value) -> bool:
    return isinstance(value, list | tuple)


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float | complex) and not isinstance(value, bool)


def _without_spaces_and_case(text: str) -> str:
    return "".join(text.split()).casefold()


def _find_slip(expected: Value, got: Value) -> str | None:
    if got is None and expected is not None:
        return "sans_retour"
    return "nan" if isinstance(got, float) and math.isnan(got) else None


def _place_text(path: str) -> str:
    """Return where two values differ: « À l’indice 1 : », « Pour la clé 'le' : », « En [0]['le'] : »."""
    inside = path[1:-1]
    if not path or "][" in path:
        return f"En {path} : " if path else ""
    return f"À l’indice {inside} : " if inside.isdecimal() else f"Pour la clé {inside} : "


def _item_count_text(count: int) -> str:
    return "Il n’y a aucun élément" if count == 0 else f"Il y a {count} élément{'s' if count > 1 else ''}"


def _pair_text(expected: Value, got: Value) -> str:
    wanted, obtained = python_text_pair(expected, got)
    return f"{obtained} au lieu de {wanted}"


def _value_difference_sentence(expected: Value, got: Value, path: str) -> str:
    return f"{_place_text(path)}{_pair_text(expected, got)}." if path else ""


def _wrong_nature_sentence(expected: Value, got: Value, path: str) -> str:
    if got is None:
        return f"{_place_text(path)}On attend {nature_text(expected)}, et la fonction ne renvoie rien (None)."
    if isinstance(got, RaisedException):
        return f"On attend {nature_text(expected)}, et l’exception {got} est levée."
    if isinstance(expected, RaisedException):
        return f"On attend {nature_text(expected)}, et aucune exception n’est levée."
    return f"{_place_text(path)}On attend {nature_text(expected)}, pas {nature_text(got)}."


def _missing_items_text(noun: str, items: list[Value]) -> str:
    if not items:
        return ""
    article = "les " if len(items) > 1 else "la " if noun == "clé" else "l’"
    return f"il manque {article}{noun}{'s' if len(items) > 1 else ''} {_items_text(items)}"


def _extra_items_text(noun: str, items: list[Value]) -> str:
    return f"{_items_text(items)} {'est' if len(items) == 1 else 'sont'} de trop" if items else ""


def _items_text(items: list[Value]) -> str:
    return ", ".join(map(python_text, items[:NAMED])) + (", …" if len(items) > NAMED else "")


def _join_into_sentence(*parts: str) -> str:
    told = " et ".join(part for part in parts if part)
    return told[:1].upper() + told[1:] + "."
