"""Forms of values: of what a function is given, and of what it may return.

A form says in French what a value is, and makes of a right answer the same answer in each other form that is accepted
(a list for an array, an array of one item for a number), and answers that are outside of it. The same objects are
shown to students, and graders are tested with what they make.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np

from graders.core.contract.values import Floats, Value

#: A size, or the letter of one that changes from call to call.
Size = int | str
Shape = tuple[Size, ...]
#: A tolerance from which a computation in single precision is always near enough, and one below which it never is.
ENOUGH_FOR_SINGLE, TOO_FINE_FOR_SINGLE = 1e-5, 1e-8
#: The part of a tolerance by which an answer that must pass is moved.
WELL_WITHIN = 0.4
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_TYPES = {"float64": "réels", "bool": "booléens", "int64": "entiers"}


class AcceptedVariant(NamedTuple):
    """An answer in another form, which `name` says in French."""

    name: str
    value: Value


class RefusedAnswer(NamedTuple):
    """An answer outside a form, and words of which its refusal must hold one."""

    name: str
    value: Value
    words: tuple[str, ...]


NOTHING = RefusedAnswer("None", None, ("return", "None"))
TEXT = RefusedAnswer("un texte", "résultat", ("texte", "nombres"))


@dataclass(frozen=True, kw_only=True)
class ValueForm(ABC):
    """A form of values. `precision` is a sentence for what a tolerance alone does not say."""

    tolerance: float | None = None
    precision: str = ""

    @property
    @abstractmethod
    def description(self) -> str:
        """The form, as « un tableau (n, 3) »."""

    @property
    def accepted_alternatives(self) -> str:
        """The other forms that are accepted, as an end of « Convient : »; empty where there are none."""
        return ""

    @abstractmethod
    def matches(self, value: Value, sizes: dict[str, int]) -> bool:
        """Whether a value that programs are given has exactly this form; `sizes` are those of the letters so far."""

    @abstractmethod
    def accepted_variants(self, value: Value) -> Iterator[AcceptedVariant]:
        """Yield a right answer in each form that is accepted."""

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        """Yield answers that must be refused for their form."""
        yield from (NOTHING, TEXT)

    def precision_text(self) -> str:
        """Return how near an answer must be, in French; empty where nothing is said of it."""
        return self.precision or ("" if self.tolerance is None else tolerance_text(self.tolerance))


FormT = TypeVar("FormT", bound=ValueForm)


def with_tolerance(form: FormT, tolerance: float) -> FormT:
    """Return the form with a tolerance, where it has neither that nor a precision of its own."""
    return form if form.tolerance is not None or form.precision else replace(form, tolerance=tolerance)


def tolerance_text(tolerance: float) -> str:
    """« À 10⁻⁹ près : relatif au-dessus de 1, absolu en dessous. Un calcul en float32 ne suffit pas. »"""
    single = ""
    if tolerance >= ENOUGH_FOR_SINGLE:
        single = " Un calcul en float32 suffit."
    elif tolerance <= TOO_FINE_FOR_SINGLE:
        single = " Un calcul en float32 ne suffit pas."
    return f"À {power_text(tolerance)} près, de la valeur si elle dépasse 1, dans l’absolu sinon.{single}"


def power_text(value: float) -> str:
    """« 10⁻⁹ », « 5·10⁻⁴ »."""
    mantissa, exponent = f"{value:.0e}".split("e")
    power = f"10{str(int(exponent)).translate(_SUPERSCRIPTS)}"
    return power if mantissa == "1" else f"{mantissa}·{power}"


@dataclass(frozen=True, kw_only=True)
class NumberForm(ValueForm):
    """A real number."""

    called: str = "un nombre"

    @property
    def description(self) -> str:
        return self.called

    @property
    def accepted_alternatives(self) -> str:
        return "flottant ou entier, de Python ou de numpy ; tableau 0-d, (1,) ou (1, 1)"

    def matches(self, value: Value, sizes: dict[str, int]) -> bool:
        return type(value) is float

    def accepted_variants(self, value: Value) -> Iterator[AcceptedVariant]:
        number = float(np.asarray(value).item())
        yield AcceptedVariant("un flottant", number)
        yield AcceptedVariant("un flottant de numpy", np.float64(number))
        yield AcceptedVariant("un tableau 0-d", np.array(number))
        yield AcceptedVariant("un tableau (1,)", np.array([number]))
        yield AcceptedVariant("un tableau (1, 1)", np.array([[number]]))
        if number == round(number) and abs(number) < 2**53:
            yield AcceptedVariant("un entier", round(number))
            yield AcceptedVariant("un entier de numpy", np.int64(round(number)))
        if self.tolerance is not None:
            yield AcceptedVariant("à la précision demandée", move_within_tolerance(number, self.tolerance))

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        number = float(np.asarray(value).item())
        yield from super().refused_answers(value)
        yield RefusedAnswer("une liste d’un nombre", [number], ("(1,)", "tableau", "forme"))
        yield RefusedAnswer("deux nombres", (number, number), ("(2,)", "tableau", "forme", "2 valeurs"))
        yield RefusedAnswer("un nombre complexe", complex(number, 1.0), ("réels",))
        yield RefusedAnswer("nan", math.nan, ("nan", "fini"))


@dataclass(frozen=True, kw_only=True)
class WholeNumberForm(NumberForm):
    """A whole number, of either type where it is returned."""

    called: str = "un entier"

    @property
    def accepted_alternatives(self) -> str:
        return "entier de Python ou de numpy, flottant entier (3.0), tableau 0-d, (1,) ou (1, 1)"

    def matches(self, value: Value, sizes: dict[str, int]) -> bool:
        return type(value) is int

    def precision_text(self) -> str:
        return ""


@dataclass(frozen=True, kw_only=True)
class ArrayForm(ValueForm):
    """An array of this shape. `angle` is the place, in the last axis, of an angle counted modulo 2 pi; `names` are
    those of its values in the statement, if any."""

    shape: Shape
    dtype: str = "float64"
    called: str = "un tableau"
    angle: int | None = None
    names: tuple[str, ...] = ()

    @property
    def description(self) -> str:
        return f"{self.called} {shape_text(self.shape)}{_dtype_suffix(self.dtype)}"

    @property
    def accepted_alternatives(self) -> str:
        nested = " imbriqués" if len(self.shape) > 1 else ""
        half = " ; −π comme π pour un demi-tour" if self.angle is not None else ""
        return f"tableau numpy, liste ou tuple{nested}, de flottants ou d’entiers{half}"

    def matches(self, value: Value, sizes: dict[str, int]) -> bool:
        array = type(value) is np.ndarray and str(value.dtype) == self.dtype and value.ndim == len(self.shape)
        return array and all(_fits_size(size, got, sizes) for size, got in zip(self.shape, value.shape, strict=True))

    def accepted_variants(self, value: Value) -> Iterator[AcceptedVariant]:
        array = np.asarray(value, dtype=np.float64)
        yield AcceptedVariant("un tableau", array)
        yield AcceptedVariant("une liste", array.tolist())
        yield AcceptedVariant("un tuple", nested_tuple(array))
        yield AcceptedVariant("une liste de nombres ou de lignes de numpy", list(array))
        yield AcceptedVariant("une vue", np.asarray(array[::-1])[::-1])
        yield AcceptedVariant("un tableau rangé par colonnes", np.asfortranarray(array))
        if np.array_equal(array, np.round(array)):
            yield AcceptedVariant("un tableau d’entiers", array.astype(np.int64))
        if self.angle is not None:
            yield AcceptedVariant("l’autre demi-tour", flip_half_turns(array, self.angle))
        if self.tolerance is not None:
            near = move_within_tolerance(array, self.tolerance)
            if self.angle is not None:  # absolute, and within [-pi, pi]
                angles = array[..., self.angle]
                near[..., self.angle] = angles - np.sign(angles) * WELL_WITHIN * self.tolerance
            yield AcceptedVariant("à la précision demandée", near)
            if self.tolerance >= ENOUGH_FOR_SINGLE:
                yield AcceptedVariant("en float32", array.astype(np.float32))

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        array = np.asarray(value, dtype=np.float64)
        named = ("forme", "tableau", "pose", "nombre", "valeurs", "lignes", "suite")
        yield from super().refused_answers(value)
        yield RefusedAnswer("un seul nombre", 1.0, named)
        yield RefusedAnswer("un axe de trop", array[None, None], named)
        if len(array) > 1 and not isinstance(self.shape[0], str):
            yield RefusedAnswer("un élément de moins", array[1:], named)
        yield RefusedAnswer("des nombres complexes", array + 1j, ("réels",))
        if array.size:
            yield RefusedAnswer("des nan", np.full_like(array, np.nan), ("nan", "fini"))


def _dtype_suffix(dtype: str) -> str:
    return "" if dtype == "float64" else f" de {_TYPES[dtype]}"


@dataclass(frozen=True, kw_only=True)
class IndicesForm(ValueForm):
    """A row of whole numbers; `may_be_empty` where there may be none."""

    called: str = "une suite d’indices croissants"
    may_be_empty: bool = True

    @property
    def description(self) -> str:
        return self.called

    @property
    def accepted_alternatives(self) -> str:
        empty = ", vide s’il n’y en a pas" if self.may_be_empty else ""
        return f"liste, tuple ou tableau à une dimension{empty} ; entiers, ou flottants entiers (3.0)"

    def matches(self, value: Value, sizes: dict[str, int]) -> bool:
        return type(value) is list and all(type(item) is int for item in value)

    def accepted_variants(self, value: Value) -> Iterator[AcceptedVariant]:
        indices = [int(item) for item in value]
        yield AcceptedVariant("une liste", indices)
        yield AcceptedVariant("un tuple", tuple(indices))
        yield AcceptedVariant("un tableau d’entiers", np.array(indices, dtype=np.int64))
        yield AcceptedVariant("une liste d’entiers de numpy", [np.int64(item) for item in indices])
        yield AcceptedVariant("un tableau de flottants entiers", np.array(indices, dtype=np.float64))

    def refused_answers(self, value: Value) -> Iterator[RefusedAnswer]:
        named = ("indices", "indice")
        yield from super().refused_answers(value)
        yield RefusedAnswer("un seul nombre", 1, named)
        yield RefusedAnswer("un tableau à deux dimensions", np.array([list(value)]), named)
        yield RefusedAnswer("des nombres qui ne sont pas entiers", [item + 0.5 for item in value] or [0.5], named)


def _fits_size(size: Size, got: int, sizes: dict[str, int]) -> bool:
    return got == (size if isinstance(size, int) else sizes.setdefault(size, got))


def shape_text(shape: Shape) -> str:
    """« (n, 3) », « (3,) »."""
    return f"({shape[0]},)" if len(shape) == 1 else f"({', '.join(map(str, shape))})"


def nested_tuple(array: Floats) -> Value:
    """Return the items of an array as tuples of tuples."""
    return tuple(map(nested_tuple, array)) if array.ndim > 1 else tuple(array.tolist())


def move_within_tolerance(value: Value, tolerance: float) -> Value:
    """Return numbers moved by a good part of the tolerance."""
    return value + WELL_WITHIN * tolerance * np.maximum(1.0, np.abs(value))


def flip_half_turns(array: Floats, place: int) -> Floats:
    """Return the same angles, those of half a turn with their other sign."""
    turned = array.copy()
    angles = turned[..., place]
    turned[..., place] = np.where(np.abs(np.abs(angles) - math.pi) < 1e-12, -angles, angles)
    return turned


def join_with_and(items: Sequence[str]) -> str:
    """« a, b et c »."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} et {items[-1]}"


NUMBER = NumberForm()
WHOLE = WholeNumberForm()
POSE = ArrayForm(shape=(3,), called="une pose", angle=2)
GRID = ArrayForm(shape=("H", "W"), dtype="bool")


def array(*shape: Size) -> ArrayForm:
    """Return the form of an array of this shape."""
    return ArrayForm(shape=shape)


def poses(size: Size = "n") -> ArrayForm:
    """Return the form of so many poses."""
    return ArrayForm(shape=(size, 3), called="des poses", angle=2)
