"""Plain values returned by a student's program, and their reading as numbers.

A program returns exact base types only: null, bool, int, float, complex, str, ndarray, and tuples, lists and
dictionaries of these. Reading is generous about the container (list, tuple, array) and strict about the content.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Value: TypeAlias = Any
Arguments: TypeAlias = tuple[Value, ...]
Floats: TypeAlias = NDArray[np.float64]

NUMERIC_KINDS = "biuf"
#: Bytes of one compact value, beyond which it is a digest; the largest right answer of the course takes 20 KB.
MAX_COMPACT_BYTES = 1 << 16
#: More numbers than this are not read one by one, in Python: huge integers, indices.
MAX_READ_ONE_BY_ONE = 20_000


class UnreadableError(Exception):
    """A value that cannot be read as what a function must return; `args[0]` says why, in French."""


def read_array(value: Value) -> Floats:
    """Read nested lists, tuples or an array of real numbers as a float64 array of the same shape.

    Raises UnreadableError for anything else (None, text, ragged lists, complex numbers with an imaginary part).
    """
    if type(value) is np.ndarray and value.dtype == np.float64 and value.size:
        return value.astype(np.float64)
    if value is None:
        raise UnreadableError("la fonction n'a rien renvoyé (None) : il manque sans doute un « return »")
    if isinstance(value, str | dict):
        raise UnreadableError(f"la fonction renvoie {_kind_text(value)} au lieu de nombres")
    if holds_text(value):
        raise UnreadableError("la fonction renvoie autre chose que des nombres réels")
    try:
        array = np.asarray(value)
    except ValueError:
        raise UnreadableError("la fonction renvoie des lignes qui n'ont pas toutes la même longueur") from None
    if array.dtype.kind == "c" and not np.any(array.imag):
        array = array.real
    if array.size == 0:
        return np.zeros(array.shape)
    if array.dtype.kind not in NUMERIC_KINDS:
        return _read_object_array(array)
    return array.astype(np.float64)


def holds_text(value: Value) -> bool:
    """Whether a value contains text: numpy would make every item as long as the longest one."""
    if isinstance(value, list | tuple):
        return any(map(holds_text, value))
    return isinstance(value, str)


def _read_object_array(array: NDArray[Any]) -> Floats:
    """Integers too large for int64 arrive as an object array; everything else of that kind is unreadable."""
    if array.size > MAX_READ_ONE_BY_ONE:
        raise UnreadableError(f"la fonction renvoie {array.size} valeurs, dont des entiers immenses")
    if array.dtype.kind == "O" and all(isinstance(x, int | float) for x in array.flat):
        return np.array([_to_float_or_infinity(x) for x in array.flat]).reshape(array.shape)
    raise UnreadableError("la fonction renvoie autre chose que des nombres réels")


def _to_float_or_infinity(number: float) -> float:
    try:
        return float(number)
    except OverflowError:
        return np.inf if number > 0 else -np.inf


def read_scalar(value: Value) -> float:
    """Read a number, or an array of one number such as (1, 1), as a float. Raises UnreadableError."""
    array = read_array(value)
    if array.shape != () and not is_single_number_array(value):
        raise UnreadableError(f"la fonction renvoie un tableau de forme {array.shape} au lieu d'un seul nombre")
    return float(array.item())


def is_single_number_array(value: Value) -> bool:
    """Whether a value is an array of numpy that holds one number, such as a product of matrices gives."""
    return isinstance(value, np.ndarray) and value.size == 1


def read_indices(value: Value) -> list[int]:
    """Read a list, tuple or 1-D array of whole numbers. Raises UnreadableError."""
    array = read_array(value)
    if array.ndim != 1:
        raise UnreadableError(f"la fonction renvoie un tableau de forme {array.shape} au lieu d'une liste d'indices")
    if array.size > MAX_READ_ONE_BY_ONE:
        raise UnreadableError(f"la fonction renvoie {array.size} indices, bien plus qu'il n'y a de choses à désigner")
    if not np.all(np.isfinite(array)) or np.any(array != np.round(array)):
        raise UnreadableError("la fonction renvoie des nombres qui ne sont pas des indices entiers")
    return [int(x) for x in array]


def _kind_text(value: Value) -> str:
    return "un texte" if isinstance(value, str) else "un dictionnaire"


@dataclass(frozen=True)
class ValueDigest:
    """Digest of a value too large to keep: equal for the same numbers of the same types."""

    digest: bytes


def compact_value(value: Value) -> Value:
    """Return an equivalent value for `same_value`, of bounded size: nested numbers as one array, or a digest."""
    small = _to_arrays(value)
    if _memory_size_bytes(small) <= MAX_COMPACT_BYTES:
        return small
    digest = hashlib.blake2b()
    _update_digest(digest, small)
    return ValueDigest(digest.digest())


def _to_arrays(value: Value) -> Value:
    if isinstance(value, dict):
        return {key: _to_arrays(item) for key, item in value.items()}
    if not isinstance(value, list | tuple):
        return value
    try:
        return read_array(value)
    except UnreadableError:
        return tuple(_to_arrays(item) for item in value)


def _update_digest(digest: hashlib.blake2b, value: Value) -> None:
    """Update the digest with an unambiguous encoding of a value."""
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(value.tobytes())
    elif isinstance(value, dict | tuple):
        digest.update(f"{type(value).__name__}{len(value)}".encode())
        for item in value.items() if isinstance(value, dict) else value:
            _update_digest(digest, item)
    else:
        digest.update(repr(value).encode() + b"\0")


def _memory_size_bytes(value: Value) -> int:
    """Return the approximate size of a value in memory."""
    if isinstance(value, dict):
        return sum(100 + len(key) + _memory_size_bytes(item) for key, item in value.items())
    if isinstance(value, tuple):
        return sum(100 + _memory_size_bytes(item) for item in value)
    return int(value.nbytes) if isinstance(value, np.ndarray) else len(value) if isinstance(value, str) else 32


def same_value(left: Value, right: Value, *, tolerance: float = 1e-7) -> bool:
    """True when two plain values hold the same numbers in the same shape (NaN equals NaN)."""
    if isinstance(left, ValueDigest) or isinstance(right, ValueDigest):
        return bool(left == right) if type(left) is type(right) else False
    if isinstance(left, np.ndarray) and isinstance(right, np.ndarray):
        same_numbers = left.dtype == right.dtype == np.float64 and left.tobytes() == right.tobytes()
        if same_numbers or left.shape != right.shape:
            return bool(left.shape == right.shape)
    if isinstance(left, dict) and isinstance(right, dict):
        return left.keys() == right.keys() and all(
            same_value(left[key], right[key], tolerance=tolerance) for key in left
        )
    if isinstance(left, str) or isinstance(right, str) or left is None or right is None:
        return left is right or (isinstance(left, str) and isinstance(right, str) and left == right)
    try:
        a, b = read_array(left), read_array(right)
    except UnreadableError:
        return _same_items(left, right, tolerance)
    return a.shape == b.shape and bool(are_elements_close(a, b, tolerance).all())


def are_elements_close(a: Floats, b: Floats, tolerance: float) -> NDArray[np.bool_]:
    """`np.isclose(a, b, tolerance, tolerance, equal_nan=True)`, much faster on the small arrays of a diagnosis."""
    with np.errstate(invalid="ignore", over="ignore"):
        close = (np.abs(a - b) <= tolerance + tolerance * np.abs(b)) & np.isfinite(b)
    return np.asarray(close | (a == b) | (np.isnan(a) & np.isnan(b)))


def _same_items(left: Value, right: Value, tolerance: float) -> bool:
    """Tuples of differently shaped arrays, such as (R, t), are the same when their items are."""
    left, right = (value.tolist() if isinstance(value, np.ndarray) else value for value in (left, right))
    if not isinstance(left, tuple | list) or not isinstance(right, tuple | list):
        return type(left) is type(right) and bool(left == right)
    return len(left) == len(right) and all(
        same_value(a, b, tolerance=tolerance) for a, b in zip(left, right, strict=True)
    )
