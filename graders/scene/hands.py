"""Authoring API of manipulations: drawings in which the reader moves, places or draws something.

A folder `curriculum/<module>/manipulations/<name>/` holds

    scene.py     TITLE, ALT, PARAMETERS and compute(values, rng), as a replay has them (see `graders.scene.replay`);
                 `compute` answers a `Start`, what the hand begins with, or the `Replay` of what was placed or drawn
    main.js      export function begin(bench, scene): what follows the hand, in the reader's browser, with the tools
                 of `bench` (see `server/frontend/src/js/manipulations/bench.js`)
    *.js         what main.js imports: the numerics, without a page, which tests hold equal to `reference/`
    figure.py    the drawing `manipulation-<name>`, which stands there for who has no script (see
                 `server/text/markup/README.md`)

In a lesson, `::: manipulation <name>` shows it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graders.scene.parameters import RefusedError
from graders.scene.replay import Key, View
from graders.typography import french

SPOT = re.compile(r"([0-9]{1,2}(?:\.[0-9]{1,2})?),([0-9]{1,2}(?:\.[0-9]{1,2})?),([0-9]{1,3})")


@dataclass(frozen=True, eq=False)
class Start:
    """Initial state of a manipulation: the visible rectangle, `data` of plain values, and a legend."""

    view: View
    data: Mapping[str, Any]
    legend: Sequence[Key] = ()

    def wire(self) -> dict[str, Any]:
        return {**self.view.wire(), "data": dict(self.data), "legend": [key.wire() for key in self.legend]}


@dataclass(frozen=True)
class ReplayRequest:
    """Whether the script requests a replay from `compute`, rather than the initial state; it has no widget."""

    label: str = "Demandé"
    default: bool = False

    def read(self, text: str) -> bool:
        if text not in ("0", "1"):
            raise RefusedError("les valeurs possibles sont 0 et 1")
        return text == "1"

    def describe(self) -> dict[str, Any]:
        return {"kind": "asked"}


@dataclass(frozen=True)
class Spots:
    """Places (x, y) within `box` = (x0, y0, x1, y1) that the reader touched, each with how many were put there:
    "x,y,n;x,y,n", at most `most` places and `total` in all; none is the empty text."""

    label: str
    box: tuple[float, float, float, float]
    most: int
    total: int
    default: str = ""

    @property
    def longest(self) -> int:
        return 16 * self.most

    def read(self, text: str) -> str:
        spots = spots_of(text)
        x0, y0, x1, y1 = self.box
        if len(spots) > self.most or sum(count for _, _, count in spots) > self.total:
            raise RefusedError(f"au plus {self.most} endroits et {self.total} particules")
        if not all(x0 <= x <= x1 and y0 <= y <= y1 and count > 0 for x, y, count in spots):
            raise RefusedError("un endroit est hors du dessin, ou vide")
        return text

    def describe(self) -> dict[str, Any]:
        return {"kind": "spots", "box": list(self.box), "most": self.most, "total": self.total}


def spots_of(text: str) -> list[tuple[float, float, int]]:
    """The places of a text that a parameter `Spots` has. Raises RefusedError."""
    if not text:
        return []
    matches = [SPOT.fullmatch(part) for part in text.split(";")]
    if None in matches:
        raise RefusedError("des endroits sont attendus, écrits x,y,nombre et séparés par des points-virgules")
    return [(float(match[1]), float(match[2]), int(match[3])) for match in matches if match]


@dataclass(frozen=True)
class Cells:
    """A drawing of black and white cells (rows, columns), row 0 first, as hexadecimal digits of four cells each;
    `rows` times `columns` is a multiple of 4."""

    label: str
    rows: int
    columns: int
    default: str

    def __post_init__(self) -> None:
        assert self.rows * self.columns % 4 == 0, self.label
        assert self.read(self.default) == self.default, self.label

    @property
    def longest(self) -> int:
        return self.rows * self.columns // 4

    def read(self, text: str) -> str:
        if not re.fullmatch(f"[0-9a-f]{{{self.longest}}}", text):
            raise RefusedError(f"{self.longest} chiffres hexadécimaux sont attendus")
        return text

    def describe(self) -> dict[str, Any]:
        return {"kind": "cells", "label": french(self.label), "rows": self.rows, "columns": self.columns}

    def cells(self, text: str) -> NDArray[np.bool_]:
        """The drawing (rows, columns): True where it is black."""
        digits = np.array([int(digit, 16) for digit in text])
        bits = digits[:, None] >> np.array([3, 2, 1, 0]) & 1
        cells: NDArray[np.bool_] = bits.reshape(self.rows, self.columns) == 1
        return cells


def cells_text(cells: NDArray[np.bool_]) -> str:
    """The hexadecimal digits of a drawing (rows, columns)."""
    bits = cells.astype(np.int64).reshape(-1, 4)
    return "".join(f"{digit:x}" for digit in bits @ np.array([8, 4, 2, 1]))
