"""Numbers made small for the wire: arrays as 16-bit integers, pictures as bytes, single numbers rounded.

`static/js/replays/decode.js` reads them back.
"""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

LARGEST = 32767
FINEST = 1e-4
SIGNIFICANT = 4


class SceneError(InvalidArgumentError):
    """Something that cannot be shown; `argument` names it."""


def finite(name: str, values: ArrayLike, columns: int | None = None) -> NDArray[np.float64]:
    """An array of finite numbers, (n, columns) or (n,). Raises SceneError."""
    array = np.asarray(values, dtype=np.float64)
    if columns is not None and array.size == 0:
        array = array.reshape(0, columns)
    expected = 1 if columns is None else 2
    if array.ndim != expected or (columns is not None and array.shape[1] != columns):
        raise SceneError(name, f"sa forme est {array.shape}, et non {'(n,)' if columns is None else f'(n, {columns})'}")
    if not np.all(np.isfinite(array)):
        raise SceneError(name, "un des nombres n’est pas fini")
    return array


def packed(array: NDArray[np.float64]) -> dict[str, Any]:
    """An array (n,) or (n, k) as integers times the finest power of ten that suffices, no finer than 1e-4."""
    largest = max(float(np.abs(array).max(initial=0.0)), FINEST)
    exponent = max(round(math.log10(FINEST)), math.ceil(math.log10(largest / LARGEST)))
    integers = np.rint(array / 10.0**exponent).astype("<i2")
    columns = array.shape[1] if array.ndim == 2 else 1
    return {"k": columns, "e": exponent, "d": base64.b64encode(integers.tobytes()).decode("ascii")}


def picture(cells: NDArray[np.float64]) -> dict[str, Any]:
    """Encode cells (H, W) of numbers in [0, 1] as bytes 0..255; HTTP compression removes repetitions."""
    height, width = cells.shape
    data = np.rint(np.clip(cells, 0.0, 1.0) * 255.0).astype(np.uint8)
    return {"w": width, "h": height, "d": base64.b64encode(data.tobytes()).decode("ascii")}


def rounded(value: float, significant: int = SIGNIFICANT) -> float | int | None:
    """Round to few significant digits, to an int where possible; None for NaN and infinities (a gap in a curve)."""
    if not math.isfinite(value):
        return None
    if value == 0.0:
        return 0
    number = round(value, significant - 1 - math.floor(math.log10(abs(value))))
    return int(number) if number == int(number) and abs(number) < 1e15 else number
