"""Calls that a verdict's failed checks show, which are kept as JSON, in the forms that their function is given."""

from __future__ import annotations

from typing import Any

import numpy as np

from graders.core.contract.values import Arguments, Value


def convert_to_call_types(call: Arguments, shown: Arguments) -> Arguments | None:
    """Return the shown arguments in the types of those of a call; None where they have another form."""
    if len(shown) > len(call):
        return None
    try:
        return tuple(_convert_to_type_of(model, value) for model, value in zip(call, shown, strict=False))
    except (ValueError, TypeError):
        return None


def _convert_to_type_of(model: Value, value: Any) -> Value:
    """Return a value in the type of a model, each item of a list in that of the model's first one."""
    if isinstance(model, np.ndarray):
        return np.array(value, dtype=model.dtype)
    if isinstance(model, tuple):
        return tuple(_convert_to_type_of(item, part) for item, part in zip(model, value, strict=True))
    if isinstance(model, list):
        if not model:
            raise ValueError("an empty list tells no type")
        return [_convert_to_type_of(model[0], part) for part in value]
    return value if model is None or isinstance(model, dict) else type(model)(value)
