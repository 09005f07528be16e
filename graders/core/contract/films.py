"""Films: the run of a program in a check, as plain JSON stored beside the verdict until somebody watches it.

They are made before the verdict is returned: this code costs about a tenth of a microsecond a byte.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from typing import Any

import numpy as np

from graders.core.contract.findings import FigureData

log = logging.getLogger(__name__)

#: Bytes of all the films of one grading together, as JSON, apart from the limit of the verdict.
FILM_BYTES = 192 * 1024


def film_to_json(data: FigureData, max_bytes: int = FILM_BYTES) -> FigureData | None:
    """Return the film as strict JSON values, arrays as lists; None where it exceeds `max_bytes`.

    Numbers that are not finite become None. Data that JSON cannot hold is our error: it is logged, without effect on
    the verdict.
    """
    try:
        text = _dump_film(data)
    except (TypeError, ValueError, RecursionError):
        log.exception("a film is not made of plain values")
        return None
    return json.loads(text) if len(text) <= max_bytes else None


def drop_heaviest_films(films: Mapping[str, FigureData], max_bytes: int = FILM_BYTES) -> dict[str, FigureData]:
    """Return the films that fit in `max_bytes` together; the largest are dropped first."""
    weights = {check: len(json.dumps(film, allow_nan=False)) for check, film in films.items()}
    left = sum(weights.values())
    remaining = dict(films)
    for check in sorted(weights, key=lambda check: -weights[check]):
        if left <= max_bytes:
            break
        del remaining[check]
        left -= weights[check]
    return remaining


def _dump_film(data: FigureData) -> str:
    try:
        return json.dumps(data, allow_nan=False, default=_array_to_list)
    except ValueError:
        return json.dumps(_replace_non_finite_by_none(data), allow_nan=False)


def _array_to_list(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"a film cannot hold {type(value).__name__}")


def _replace_non_finite_by_none(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return _replace_non_finite_by_none(value.tolist())
    if isinstance(value, dict):
        return {key: _replace_non_finite_by_none(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_replace_non_finite_by_none(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
