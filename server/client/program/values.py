"""Values of a verdict laid out for a terminal, as Python writes them: one row of a matrix a line, aligned."""

from __future__ import annotations

from typing import Any

MAX_ROWS, MAX_COLUMNS = 12, 10
SPECIAL_NUMBERS = frozenset({"nan", "inf", "-inf"})


def format_assignment(value: Any, name: str) -> list[str]:
    """Return the lines of `name = value`."""
    head = f"{name} = "
    first, *others = _format_value(value)
    return [head + first, *(" " * len(head) + line for line in others)]


def _format_value(value: Any) -> list[str]:
    if isinstance(value, str):
        return value.splitlines() or [repr(value)]
    if isinstance(value, dict):
        return [f"{key}: {' '.join(_format_value(item))}" for key, item in list(value.items())[:MAX_ROWS]] or ["{}"]
    if isinstance(value, list):
        return (
            _format_matrix(value)
            if _is_matrix(value)
            else ["[" + ", ".join(_shorten_long_row([_format_inline(item) for item in value])) + "]"]
        )
    return [_format_inline(value)]


def _is_matrix(rows: list[Any]) -> bool:
    widths = {len(row) if isinstance(row, list) else None for row in rows}
    return len(rows) > 1 and len(widths) == 1 and None not in widths


def _format_matrix(rows: list[list[Any]]) -> list[str]:
    cells = [_shorten_long_row([_format_inline(item) for item in row]) for row in rows[:MAX_ROWS]]
    widths = [max(map(len, column)) for column in zip(*cells)]
    lines = [", ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in cells]
    lines = [f"{'[[' if number == 0 else ' ['}{line}]" for number, line in enumerate(lines)]
    if len(rows) > MAX_ROWS:
        lines.append(f" … {len(rows) - MAX_ROWS} lignes de plus")
    return [*lines[:-1], lines[-1] + "]"]


def _shorten_long_row(texts: list[str]) -> list[str]:
    return texts if len(texts) <= MAX_COLUMNS else [*texts[: MAX_COLUMNS - 1], f"… ({len(texts)} valeurs)"]


def _format_inline(value: Any) -> str:
    if isinstance(value, str):
        return value if value in SPECIAL_NUMBERS else repr(value)
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_format_inline, value)) + "]"
    return repr(value)
