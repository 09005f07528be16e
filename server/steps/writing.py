"""Values of a trace as Python writes them, for a page without scripts. Pure."""

from __future__ import annotations

from collections.abc import Sequence

from server.steps.schemas import (
    ArrayOut,
    BoolValueOut,
    MappingOut,
    NoneValueOut,
    NumberOut,
    OtherOut,
    SequenceOut,
    TextOut,
    Value,
)

BRACKETS = {"list": "[]", "tuple": "()", "set": "{}"}
REST = "…"


def format_traced_value(value: Value) -> str:
    """Return a value in one line; what the trace has cut ends with « … »."""
    match value:
        case SequenceOut():
            return _format_sequence(value)
        case MappingOut():
            pairs = [f"{format_traced_value(key)}: {format_traced_value(item)}" for key, item in value.items]
            return "{" + ", ".join(_with_ellipsis_if_cut(pairs, value.length)) + "}"
        case ArrayOut():
            return f"array({_format_array_rows(value.values, value.shape, cut=value.cut)})"
        case OtherOut():
            return f"<{value.type} {value.name}>" if value.name else f"<{value.type}>"
        case _:
            return _format_plain(value)


def _format_plain(value: NoneValueOut | BoolValueOut | NumberOut | TextOut) -> str:
    match value:
        case NumberOut():
            return value.text
        case TextOut():
            return repr(value.text) + (REST if len(value.text) < value.length else "")
        case BoolValueOut():
            return str(value.value)
        case NoneValueOut():
            return "None"


def _format_sequence(value: SequenceOut) -> str:
    items = _with_ellipsis_if_cut([format_traced_value(item) for item in value.items], value.length)
    brackets = BRACKETS.get(value.type)
    if brackets is None:
        return f"{value.type}([{', '.join(items)}])"
    comma = "," if value.type == "tuple" and value.length == 1 else ""
    return f"{brackets[0]}{', '.join(items)}{comma}{brackets[1]}"


def _with_ellipsis_if_cut(items: Sequence[str], length: int) -> Sequence[str]:
    return [*items, REST] if len(items) < length else items


def _format_array_rows(values: Sequence[str], shape: Sequence[int], *, cut: bool) -> str:
    """Return the numbers of an array in the brackets of its shape; of one that is cut, in a row."""
    if cut or not shape:
        row = ", ".join([*values, *([REST] if cut else [])])
        return f"[{row}]" if shape else row
    size = len(values) // shape[0] if shape[0] else 0
    parts = [values[k * size : (k + 1) * size] for k in range(shape[0])]
    if len(shape) == 1:
        return f"[{', '.join(values)}]"
    return f"[{', '.join(_format_array_rows(part, shape[1:], cut=False) for part in parts)}]"
