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
LONGEST_RUN = 255
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
        raise SceneError(name, f"has shape {array.shape}, not {'(n,)' if columns is None else f'(n, {columns})'}")
    if not np.all(np.isfinite(array)):
        raise SceneError(name, "holds a number that is not finite")
    return array


def packed(array: NDArray[np.float64]) -> dict[str, Any]:
    """An array (n,) or (n, k) as integers times the finest power of ten that suffices, no finer than 1e-4."""
    largest = max(float(np.abs(array).max(initial=0.0)), FINEST)
    exponent = max(round(math.log10(FINEST)), math.ceil(math.log10(largest / LARGEST)))
    integers = np.rint(array / 10.0**exponent).astype("<i2")
    columns = array.shape[1] if array.ndim == 2 else 1
    return {"k": columns, "e": exponent, "d": base64.b64encode(integers.tobytes()).decode("ascii")}


def picture(cells: NDArray[np.float64]) -> dict[str, Any]:
    """Cells (H, W) of numbers in [0, 1] as bytes 0..255, plain or as runs (count, byte), whichever is shorter."""
    height, width = cells.shape
    flat = np.rint(np.clip(cells, 0.0, 1.0) * 255.0).astype(np.uint8).ravel()
    runs = _runs(flat)
    shorter = runs.size < flat.size
    data = base64.b64encode((runs if shorter else flat).tobytes()).decode("ascii")
    return {"w": width, "h": height, "runs": shorter, "d": data}


def _runs(flat: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The bytes as pairs (count, byte), no count above 255."""
    starts = np.flatnonzero(np.r_[True, flat[1:] != flat[:-1]])
    lengths = np.diff(np.r_[starts, flat.size])
    parts = np.ceil(lengths / LONGEST_RUN).astype(np.int64)
    counts = np.full(int(parts.sum()), LONGEST_RUN, dtype=np.int64)
    counts[np.cumsum(parts) - 1] = lengths - (parts - 1) * LONGEST_RUN
    return np.column_stack([counts, np.repeat(flat[starts], parts)]).astype(np.uint8).ravel()


def rounded(value: float, significant: int = SIGNIFICANT) -> float | int | None:
    """A number with few digits, whole if it can be; None for what is not finite (a gap in a curve)."""
    if not math.isfinite(value):
        return None
    if value == 0.0:
        return 0
    kept = round(value, significant - 1 - math.floor(math.log10(abs(value))))
    return int(kept) if kept == int(kept) and abs(kept) < 1e15 else kept
