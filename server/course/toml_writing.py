"""Plain data written as TOML."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any


def write_toml_table(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a table whose values are scalars, lists of scalars, tables of texts, or lists of tables."""
    for key, value in data.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            for each in value:
                yield f"\n[[{key}]]\n"
                yield from write_toml_table(each)
        else:
            yield f"{key} = {write_toml_value(value)}\n"


def write_toml_value(value: Any) -> str:
    """Return a text, number, truth value, list of these or table of texts as TOML writes it."""
    if isinstance(value, list):
        return "[\n" + "".join(f"    {write_toml_value(item)},\n" for item in value) + "]"
    if isinstance(value, dict):
        return (
            "{ "
            + ", ".join(f"{write_toml_value(key)} = {write_toml_value(item)}" for key, item in value.items())
            + " }"
        )
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
