"""Values of a counterexample (plain JSON, see graders.core.compare.words) as tables and text for a French reader."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from graders.core.compare.python_values import MORE, is_numeric, is_python_text, python_text, restore_numbers
from graders.core.compare.told_apart import NOISE, are_within_tolerance, number_text_pair
from graders.core.compare.words import number

MAX_ROWS, MAX_COLUMNS, MAX_LIST = 24, 40, 24  # a map of the course is 16 × 24, a scan has 36 rays
#: Numbers of one table, and lists in one list, that are shown: a counterexample is read, and is some 2 kB long.
MAX_CELLS, MAX_LISTS = 60, 4
#: A number is marked where it differs by more; the finer tolerance counts where the coarse one marks nothing.
MARKED, MARKED_ALONE = 1e-6, 1e-9
SPECIAL = {"nan": "nan", "inf": "∞", "-inf": "\N{MINUS SIGN}∞"}
#: Characters of a value that is written in one line, as Python does.
MAX_PYTHON_LINE = 200
Kind = Literal["text", "matrix", "plan", "list", "fields"]


@dataclass(frozen=True)
class MatrixCell:
    """One number of a matrix; `odd` when it is not what was expected there."""

    text: str
    odd: bool = False


@dataclass(frozen=True)
class ValueView:
    """One value: `text` and `plan` have `text`, `matrix` has `rows`, `list` and `fields` have `items`, named in fields.

    `note` is a remark below (a shape, what has been left out).
    """

    kind: Kind
    text: str = ""
    rows: tuple[tuple[MatrixCell, ...], ...] = ()
    items: tuple[tuple[str, ValueView], ...] = ()
    note: str = ""


@dataclass(frozen=True)
class _ReferenceValue:
    """The value that another one is shown beside: by it numbers get their digits and, beyond `tolerance`, their marks.

    Without a tolerance, nothing is marked. A `short` value is that of a counterexample, which is read.
    """

    value: Any = None
    tolerance: float | None = None
    short: bool = False

    def item_references(self, count: int) -> list[_ReferenceValue]:
        """The counterparts of the items of a list of that length."""
        items = self.value if isinstance(self.value, list) and len(self.value) == count else [None] * count
        return [_ReferenceValue(item, self.tolerance, self.short) for item in items]


def build_value_view(value: Any, expected: Any = None, *, short: bool = False) -> ValueView:
    """Lay out `value`; numbers that differ from those of `expected`, where it has the same shape, are marked.

    Of a `short` one, the part that is read is laid out, from the first difference on.
    """
    marks = any(_differs_beyond_tolerance(*pair, MARKED) for pair in _iterate_number_pairs(value, expected))
    return _build_view(value, _ReferenceValue(expected, MARKED if marks else MARKED_ALONE, short))


def build_value_view_pair(expected: Any, got: Any) -> tuple[ValueView, ValueView]:
    """Lay out two values side by side: the numbers that differ have digits to tell them apart, the second's a mark."""
    return _build_view(expected, _ReferenceValue(got, short=True)), build_value_view(got, expected, short=True)


def _iterate_number_pairs(value: Any, other: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the numbers of a value with those at the same place of another one of its shape."""
    if isinstance(value, list) and isinstance(other, list) and len(value) == len(other):
        for item, counterpart in zip(value, other, strict=True):
            yield from _iterate_number_pairs(item, counterpart)
    elif _is_number(value) and _is_number(other):
        yield value, other


def _build_view(value: Any, reference: _ReferenceValue) -> ValueView:
    if isinstance(value, Mapping) and _is_array_summary(value):
        return _build_array_summary_view(value)
    if isinstance(value, Mapping | list) and (line := format_as_python_line(value)):
        return ValueView("text", line)
    if isinstance(value, Mapping):
        return _build_fields_view(value)
    if isinstance(value, list) and value:
        return _build_sequence_view(value, reference)
    return ValueView("text", _format_to_distinguish(value, reference.value))


def format_as_python_line(value: Any) -> str:
    """Return a short dictionary or list in Python's notation; empty for numbers alone, and for plans."""
    restored = restore_numbers(value)
    if is_numeric(restored) or (isinstance(value, list) and value and all(isinstance(row, list) for row in value)):
        return ""
    line = python_text(restored)
    return line if len(line) <= MAX_PYTHON_LINE and MORE not in line else ""


def name_items_of_list(laid_out: ValueView, parts: Sequence[str]) -> ValueView:
    """A list of as many values as `parts` has names, each under its own: « R = … », « t = … »."""
    items = laid_out.items
    if laid_out.kind != "list" or len(items) != len(parts) or laid_out.note:
        return laid_out
    return ValueView("fields", items=tuple((name, item) for name, (_, item) in zip(parts, items, strict=True)))


def format_scalar_in_french(value: Any) -> str:
    """A number, truth value or text in French."""
    if value is None:
        return "None"
    if isinstance(value, bool):
        return "True" if value else "False"
    if isinstance(value, int | float):
        return number(value)
    if isinstance(value, str):
        return SPECIAL.get(value, value)
    return "[ ]" if value == [] else str(value)


def _format_to_distinguish(value: Any, reference: Any) -> str:
    """A scalar, with the digits that tell it from the one that it is shown beside, if both are numbers."""
    if any(isinstance(it, bool) or not isinstance(it, int | float) for it in (value, reference)):
        return format_scalar_in_french(value)
    if are_within_tolerance(value, reference, NOISE):
        return format_scalar_in_french(value)
    return number_text_pair(value, reference)[0]


def _is_array_summary(value: Mapping[str, Any]) -> bool:
    """Whether it stands for an array too large to be kept; a dictionary that a program returned may look like one."""
    parts = [value.get("forme"), value.get("premiers", [])]
    return value.keys() <= {"forme", "premiers"} and all(isinstance(part, list) for part in parts)


def _build_array_summary_view(value: Mapping[str, Any]) -> ValueView:
    shape = " × ".join(str(size) for size in value["forme"])
    start = " ; ".join(format_scalar_in_french(item) for item in value.get("premiers", []))
    return ValueView("text", f"tableau de forme {shape}", note=f"premières valeurs : {start}" if start else "")


def _build_fields_view(value: Mapping[str, Any]) -> ValueView:
    return ValueView("fields", items=tuple((str(name), build_value_view(item)) for name, item in value.items()))


def _build_sequence_view(value: list[Any], reference: _ReferenceValue) -> ValueView:
    if _is_row_of_scalars(value):
        return _build_matrix_view([value], _ReferenceValue([reference.value], reference.tolerance, reference.short))
    if (
        all(isinstance(row, list) and _is_row_of_scalars(row) for row in value)
        and len({len(row) for row in value}) == 1
    ):
        if all(isinstance(item, bool) for row in value for item in row):
            return _build_plan_view(value)
        return _build_matrix_view(value, reference)
    return _build_list_view(value, reference)


def _is_row_of_scalars(value: list[Any]) -> bool:
    return bool(value) and all(_is_number(item) for item in value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) or (isinstance(value, str) and value in SPECIAL)


def _build_matrix_view(rows: list[list[Any]], reference: _ReferenceValue) -> ValueView:
    same, tolerance = _has_same_shape(rows, reference.value), reference.tolerance
    odd = [
        i
        for i, row in enumerate(rows)
        if same
        and any(_differs_beyond_tolerance(item, reference.value[i][j], MARKED_ALONE) for j, item in enumerate(row))
    ]
    columns = min(len(rows[0]), MAX_COLUMNS)
    shown = (
        _choose_shown_rows(len(rows), columns, odd[0] if odd else 0)
        if reference.short
        else range(min(len(rows), MAX_ROWS))
    )
    cells = tuple(
        tuple(
            MatrixCell(
                _format_to_distinguish(item, reference.value[i][j] if same else None),
                same and tolerance is not None and _differs_beyond_tolerance(item, reference.value[i][j], tolerance),
            )
            for j, item in enumerate(rows[i][:columns])
        )
        for i in shown
    )
    return ValueView("matrix", rows=cells, note=_describe_omitted_rows(rows, shown, columns))


def _choose_shown_rows(count: int, columns: int, first_odd: int) -> range:
    """Return the rows of a table that are shown: all, or as many as are read, from before the first odd one on."""
    height = min(count, MAX_ROWS, max(3, MAX_CELLS // columns))
    begin = max(0, min(first_odd - 1, count - height))
    return range(begin, begin + height)


def _describe_omitted_rows(rows: list[list[Any]], shown: range, columns: int) -> str:
    size = f"{len(rows)} × {len(rows[0])}" if len(rows) > 1 else f"{len(rows[0])} valeurs"
    if len(shown) == len(rows) and columns == len(rows[0]):
        return ""
    if shown.start == 0 or len(shown) == len(rows):
        return f"{size}, seul le début est montré"
    return f"{size}, seules les lignes d’indices {shown.start} à {shown.stop - 1} sont montrées"


def _has_same_shape(rows: list[list[Any]], expected: Any) -> bool:
    if not isinstance(expected, list) or len(expected) != len(rows):
        return False
    return all(isinstance(row, list) and len(row) == len(rows[0]) and _is_row_of_scalars(row) for row in expected)


def _differs_beyond_tolerance(got: Any, expected: Any, tolerance: float) -> bool:
    left, right = (float(it) if isinstance(it, str) else it for it in (got, expected))
    if "nan" in (str(left), str(right)):
        return str(left) != str(right)
    return not are_within_tolerance(left, right, tolerance)


def _build_plan_view(rows: list[list[bool]]) -> ValueView:
    drawing = "\n".join("".join("." if free else "#" for free in row) for row in rows)
    return ValueView("plan", drawing, note=f"{len(rows)} × {len(rows[0])} ; « . » vaut True, « # » vaut False")


def _build_list_view(value: list[Any], reference: _ReferenceValue) -> ValueView:
    most = MAX_LISTS if reference.short and any(isinstance(item, list) for item in value) else MAX_LIST
    parts = reference.item_references(len(value))[:most]
    items = tuple(("", _build_view(item, part)) for item, part in zip(value[:most], parts, strict=True))
    left = len(value) - most
    return ValueView("list", items=items, note=f"et {left} autres" if left > 0 else "")


def write_inputs_as_code(inputs: Mapping[str, Any]) -> str:
    """Python lines that give the same inputs again, to try at home; empty when a value has been cut short."""
    lines = [f"{name} = {format_as_python_literal(value)}" for name, value in inputs.items() if name.isidentifier()]
    if len(lines) != len(inputs) or any(_is_cut_short(value) for value in inputs.values()):
        return ""
    return "\n".join(lines)


def _is_cut_short(value: Any) -> bool:
    return any(isinstance(item, Mapping) and "forme" in item for item in _iterate_nested_values(value))


def _iterate_nested_values(value: Any) -> Iterator[Any]:
    yield value
    children = value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ()
    for child in children:
        yield from _iterate_nested_values(child)


def format_as_python_literal(value: Any) -> str:
    """Return the Python that gives a value of a counterexample again."""
    if not isinstance(value, list) or not value:
        return _format_plain_value(value)
    if _is_array(value):
        return f"np.array({_format_plain_value(value)})"
    return "[" + ", ".join(format_as_python_literal(item) for item in value) + "]"


def _is_array(value: list[Any]) -> bool:
    """Numbers in rows of the same length, however deep."""
    if _is_row_of_scalars(value):
        return True
    if not all(isinstance(item, list) and item and _is_array(item) for item in value):
        return False
    return len({len(item) for item in value}) == 1 and len({isinstance(item[0], list) for item in value}) == 1


def _format_plain_value(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_format_plain_value(item) for item in value) + "]"
    if isinstance(value, str) and value in SPECIAL:
        return {"nan": "np.nan", "inf": "np.inf", "-inf": "-np.inf"}[value]
    return value if isinstance(value, str) and is_python_text(value) else repr(value)
