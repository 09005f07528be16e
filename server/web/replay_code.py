"""A counterexample as a program: at the end of one's file, it makes the same call under the same conditions."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from graders.core.contract.program import KitSettings
from server.course import FunctionSpec
from server.web import values

_NAME = re.compile(r"[^\W\d]\w*")
#: Names of a kit that depend on the map, the range and the seed of an execution.
#: End of the name of an array (H, W) that is told by its cells other than 0.
_SPARSE = re.compile(r"(\w+)(?: (\(\d+, \d+\)))?, cases \(y, x\) non nulles")
_WORLD = re.compile(r"\b(?:lidar|lidar_lot|libres|PORTEE_MAX|rng|H|W)\b")


def write_replay_code(
    inputs: Mapping[str, Any], functions: Sequence[FunctionSpec], kit: KitSettings | None, solution: str = ""
) -> str:
    """Return Python lines that make the call of a counterexample again; empty where a value has been cut short.

    `kit` holds the map, the range and the seed of the check; they are told where the exercise's `solution` uses them.
    """
    world = _write_world_lines(kit, solution)
    given = {name: value for name, value in inputs.items() if not (world and name in ("libres", "portee_max"))}
    takes_world = any("libres" in _parameter_names(function.signature) for function in functions)
    inputs = inputs if takes_world else given
    lines = _write_input_lines(inputs)
    if not lines:
        return ""
    lines = [*world, *lines]
    inputs = {name.partition(",")[0].partition(" ")[0]: value for name, value in inputs.items()}
    if call := _write_function_call(inputs, functions):
        lines.append(f"print({call})")
    if any("np." in line for line in lines):
        lines.insert(0, "import numpy as np")
    return "\n".join(lines)


def _write_input_lines(inputs: Mapping[str, Any]) -> list[str]:
    """Return the lines that give the inputs again; none where one of them is described or cut short."""
    lines = []
    for name, value in inputs.items():
        if (sparse := _SPARSE.fullmatch(name)) and isinstance(value, Mapping):
            array, shape = sparse[1], sparse[2] or "(H, W)"
            cells = [f"{array}[{cell.strip('()')}] = {number!r}" for cell, number in value.items()]
            lines += [f"{array} = np.zeros({shape})", *cells]
        elif code := values.write_inputs_as_code({name: value}):
            lines.append(code)
        else:
            return []
    return lines


def _write_function_call(inputs: Mapping[str, Any], functions: Sequence[FunctionSpec]) -> str:
    """Return the call of the one function that takes the inputs of those names; empty if in doubt."""
    takers = [(function, _parameter_names(function.signature)) for function in functions]
    takers = [(function, names) for function, names in takers if inputs and inputs.keys() <= set(names)]
    if len(takers) != 1:
        return ""
    function, names = takers[0]
    return f"{function.name}({', '.join(name for name in names if name in inputs)})"


def _parameter_names(signature: str) -> list[str]:
    inside = signature.partition("(")[2].rpartition(")")[0]
    return [found[0] for part in inside.split(",") if (found := _NAME.search(part))]


def _write_world_lines(kit: KitSettings | None, solution: str) -> list[str]:
    if kit is None or "libres" not in kit.parameters or not _WORLD.search(solution):
        return []
    world = kit.parameters
    lines = [f"import {kit.module}"]
    grid = "None"
    if world["libres"] is not None:
        lines.append(f"carte = {_write_grid_rows(world['libres'])}  # « . » : libre, « # » : mur")
        grid = "[[case == '.' for case in rang] for rang in carte]"
    settings = f"libres={grid}, portee_max={world['portee_max']!r}, seed={int(world['seed'])}"
    return [*lines, f"globals().update({kit.module}.configurer({settings}))"]


def _write_grid_rows(grid: Sequence[Sequence[bool]]) -> list[str]:
    return ["".join("." if free else "#" for free in row) for row in grid]
