"""Authoring API of replays.

A file `curriculum/<module>/rejeux/<name>.py` holds

    TITLE = "…"                          shown above the drawing
    ALT = "…"                            what the drawing shows, in words, for those who do not see it
    PARAMETERS = {"rayons": Slider("Nombre de rayons", 4, 180, 4, 36), "tirage": Draw(), …}
    PREDICTION = Prediction("…", …)      what readers are asked before they play it; may be left out, or be a
                                         Placed("…", …): a place to point at on the drawing
    def compute(values: Values, rng: np.random.Generator) -> Replay: …

`compute` depends on nothing but its arguments: `rng` is seeded by the parameter of kind `Draw`, if there is one. It is
quick (a few tenths of a second) and its answer small (a few hundred kilobytes); the tests hold it to that. Texts are in
French, with plain spaces and apostrophes: the typography is set afterwards. `_{…}` lowers letters, as in N_{eff}.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from graders.scene.layers import (
    Circles,
    Color,
    Ellipse,
    Grid,
    Labels,
    Layer,
    Palette,
    Points,
    Polyline,
    Pose,
    Rays,
    Segments,
)
from graders.scene.packing import SceneError, rounded
from graders.scene.parameters import Choice, Dragged, Draw, Event, Parameter, Slider, Switch, Values
from graders.scene.prediction import Placed, Prediction
from graders.typography import french

__all__ = [
    "Chart",
    "Choice",
    "Circles",
    "Color",
    "Dragged",
    "Draw",
    "Ellipse",
    "Event",
    "Frame",
    "Grid",
    "Key",
    "Labels",
    "Layer",
    "Level",
    "Mark",
    "Palette",
    "Parameter",
    "Placed",
    "Points",
    "Polyline",
    "Pose",
    "Prediction",
    "Rays",
    "Replay",
    "SceneError",
    "Segments",
    "Series",
    "Slider",
    "Switch",
    "Values",
    "View",
    "decimal",
]

Symbol = Literal["dot", "line", "dashed", "robot", "area", "cell", "arrow", "ring"]


@dataclass(frozen=True)
class View:
    """The rectangle that is shown, in the units of the layers. `up`: y grows upwards, unlike the rows of a grid."""

    x0: float
    y0: float
    x1: float
    y1: float
    up: bool = False

    def wire(self) -> dict[str, Any]:
        if not (self.x0 < self.x1 and self.y0 < self.y1):
            raise SceneError("view", "la vue est vide")
        return {"box": [rounded(side, 6) for side in (self.x0, self.y0, self.x1, self.y1)], "up": self.up}


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture of the animation. `caption` says what happens in it; `step`, where several frames make one step of
    the algorithm, is what events count in."""

    layers: Sequence[Layer] = ()
    caption: str = ""
    step: int | None = None

    def wire(self) -> dict[str, Any]:
        body: dict[str, Any] = {"layers": [layer.wire() for layer in self.layers], "caption": french(self.caption)}
        return body if self.step is None else {**body, "step": self.step}


@dataclass(frozen=True, eq=False)
class Series:
    """A curve: `y` (n,) over `x` (n,), the numbers of the frames unless given; NaN is a gap."""

    label: str
    color: Color
    y: ArrayLike
    x: ArrayLike | None = None
    style: Literal["line", "dashed", "steps", "dots", "bars"] = "line"

    def wire(self) -> dict[str, Any]:
        y = np.asarray(self.y, dtype=np.float64)
        x = np.arange(len(y), dtype=np.float64) if self.x is None else np.asarray(self.x, dtype=np.float64)
        if y.ndim != 1 or x.shape != y.shape:
            raise SceneError("x", f"sa forme {x.shape} ne va pas avec celle de y, {y.shape}")
        points = {"x": [rounded(v, 5) for v in x.tolist()], "y": [rounded(v) for v in y.tolist()]}
        return {"label": french(self.label), "color": self.color, "style": self.style, **points}


@dataclass(frozen=True)
class Level:
    """A horizontal line across a chart: a threshold, a true value."""

    y: float
    label: str
    color: Color = "ink"


@dataclass(frozen=True)
class Mark:
    """A vertical line across a chart: where something happened."""

    x: float
    label: str
    color: Color = "alert"


@dataclass(frozen=True, eq=False)
class Chart:
    """Curves under the drawing. `cursor`: where on the x axis each frame stands, its number unless given.
    `timeless`: the x axis is no time, so that nothing is past or to come."""

    title: str
    series: Sequence[Series]
    x_label: str = ""
    y_range: tuple[float | None, float | None] = (None, None)
    logarithmic: bool = False
    levels: Sequence[Level] = ()
    marks: Sequence[Mark] = ()
    cursor: Sequence[float] | None = None
    timeless: bool = False

    def wire(self, frames: int) -> dict[str, Any]:
        cursor = range(frames) if self.cursor is None else self.cursor
        if len(cursor) != frames:
            raise SceneError("cursor", f"il y faut autant de places que d’images : {len(cursor)} pour {frames}")
        return {
            "title": french(self.title),
            "xLabel": french(self.x_label),
            "yRange": [None if bound is None else rounded(bound) for bound in self.y_range],
            "logarithmic": self.logarithmic,
            "timeless": self.timeless,
            "series": [curve.wire() for curve in self.series],
            "levels": [
                {"y": rounded(level.y), "label": french(level.label), "color": level.color} for level in self.levels
            ],
            "marks": [{"x": rounded(mark.x), "label": french(mark.label), "color": mark.color} for mark in self.marks],
            "cursor": [rounded(float(x), 5) for x in cursor],
        }  # fmt: skip


@dataclass(frozen=True)
class Key:
    """One entry of the legend."""

    symbol: Symbol
    color: Color
    label: str

    def wire(self) -> dict[str, Any]:
        return {"symbol": self.symbol, "color": self.color, "label": french(self.label)}


@dataclass(frozen=True, eq=False)
class Replay:
    """The result of `compute`: `layers` lie under every frame, `over` above it.

    `period`: seconds a frame lasts at normal speed. `begin_at_end`: shows the last frame until the reader plays it.
    `summary`: a few sentences that say what happened with these very values. `alt`: what the drawing shows, in words,
    of a replay that is no file with an ALT of its own (what a student's program did). `panels`: the titles of the
    drawings of the same view that stand side by side, to be compared; layers say in which they are. `wrong`: the frame
    at which a program went wrong, and `wrong_label` what the button that leads there says.
    """

    view: View
    frames: Sequence[Frame]
    summary: Sequence[str]
    layers: Sequence[Layer] = ()
    over: Sequence[Layer] = ()
    charts: Sequence[Chart] = ()
    legend: Sequence[Key] = ()
    period: float = 0.5
    begin_at_end: bool = False
    alt: str = ""
    panels: Sequence[str] = ()
    wrong: int | None = None
    wrong_label: str = "Aller là où ça s'écarte"

    def wire(self) -> dict[str, Any]:
        if not self.frames:
            raise SceneError("frames", "il n’y a pas une image")
        if not self.summary:
            raise SceneError("summary", "dites en une phrase ce que l’animation montre")
        for layer in (*self.layers, *self.over):
            if layer.until is not None and len(layer.until) != len(self.frames):
                raise SceneError("until", f"il y faut un nombre par image : {len(layer.until)} pour {len(self.frames)}")
        for layer in self._all_layers():
            if layer.panel is not None and not 0 <= layer.panel < len(self.panels):
                raise SceneError(
                    "panel", f"{layer.panel} n’est pas l’un des {len(self.panels)} panneaux, comptés à partir de 0"
                )
        if self.wrong is not None and not 0 <= self.wrong < len(self.frames):
            raise SceneError(
                "wrong", f"{self.wrong} n’est pas l’une des {len(self.frames)} images, comptées à partir de 0"
            )
        return {
            **self.view.wire(),
            **self._extras(),
            "layers": [layer.wire() for layer in self.layers],
            "over": [layer.wire() for layer in self.over],
            "frames": [frame.wire() for frame in self.frames],
            "charts": [chart.wire(len(self.frames)) for chart in self.charts],
            "legend": [key.wire() for key in self.legend],
            "summary": [french(sentence) for sentence in self.summary],
            "period": self.period,
            "beginAtEnd": self.begin_at_end,
        }

    def _all_layers(self) -> Iterator[Layer]:
        yield from (*self.layers, *self.over)
        for frame in self.frames:
            yield from frame.layers

    def _extras(self) -> dict[str, Any]:
        extras: dict[str, Any] = {"panels": [french(title) for title in self.panels]} if self.panels else {}
        return extras if self.wrong is None else {**extras, "wrong": [self.wrong, french(self.wrong_label)]}


def decimal(value: float, decimals: int = 1) -> str:
    """A number as it is written in French."""
    return f"{value:.{decimals}f}".replace("-", "−").replace(".", ",")
