"""Layers of a scene: each is validated when it is made, and has a wire format.

Coordinates are those of the scene's view. Colours have a meaning, the same in every replay: what is true, estimated,
measured, wrong; the reader's theme decides how each looks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from graders.scene.packing import SceneError, finite, packed, picture, rounded

Color = Literal["truth", "estimate", "measure", "alert", "second", "ink", "faint", "accent"]
Palette = Literal["walls", "occupancy", "belief", "cost", "order", "difference"]
PoseStyle = Literal["robot", "ghost", "arrow", "target"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Layer:
    """`until`: of a layer that stands in all frames, how many of its elements each frame shows.
    `glide`: between two frames, its elements move on from where the same layer of the frame before had them.
    `panel`: of a scene with several, the one that it is in (0 for the first); it is in all of them unless given."""

    until: Sequence[int] | None = None
    glide: bool = False
    panel: int | None = None

    def wire(self) -> dict[str, Any]:
        options: dict[str, Any] = {}
        if self.until is not None:
            options["until"] = [int(count) for count in self.until]
        if self.glide:
            options["glide"] = True
        if self.panel is not None:
            options["panel"] = self.panel
        return {**self._wire(), **options}

    def _wire(self) -> dict[str, Any]:
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Grid(Layer):
    """Cells (H, W) of numbers in [0, 1], row 0 first; the corner of cell (0, 0) at `corner`, `cell` units wide.

    Palettes: "walls" 1 = wall; "occupancy" 0 free, 1/2 unknown, 1 wall; "belief", "cost" and "order" see-through
    where 0; "difference" see-through at 1/2, one colour below and another above. `until` counts bytes, 0 to 255: cells
    of greater ones are not shown yet.
    """

    cells: ArrayLike
    palette: Palette
    corner: tuple[float, float] = (0.0, 0.0)
    cell: float = 1.0

    def _wire(self) -> dict[str, Any]:
        cells = np.asarray(self.cells, dtype=np.float64)
        if cells.ndim != 2 or cells.size == 0 or not np.all(np.isfinite(cells)):
            raise SceneError("cells", f"il faut un tableau de nombres (H, W) ; sa forme est {cells.shape}")
        corner = [rounded(c, 6) for c in self.corner]
        return {
            "kind": "grid", "palette": self.palette, "corner": corner, "cell": self.cell, **picture(cells)
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Points(Layer):
    """Points (n, 2), `size` pixels in radius; `weights` (n,) in [0, 1] make some stand out, `headings` (n,) point.

    `at` None, in a frame: the points and headings that the same layer of the frame before has.
    """

    at: ArrayLike | None
    color: Color
    size: float = 2.5
    weights: ArrayLike | None = None
    headings: ArrayLike | None = None
    opacity: float = 0.9

    def _wire(self) -> dict[str, Any]:
        body: dict[str, Any] = {"kind": "points", "color": self.color, "size": self.size, "opacity": self.opacity}
        if self.at is None:
            return body if self.weights is None else {**body, "weights": packed(finite("weights", self.weights))}
        at = finite("at", self.at, 2)
        body["at"] = packed(at)
        for name, values in (("weights", self.weights), ("headings", self.headings)):
            if values is not None:
                column = finite(name, values)
                if len(column) != len(at):
                    raise SceneError(name, f"il en faut un par point : {len(column)} pour {len(at)}")
                body[name] = packed(np.round(column, 2 if name == "weights" else 3))
        return body


@dataclass(frozen=True, eq=False)
class Pose(Layer):
    """A pose (3,): a robot of `radius` units, its outline only, an arrow, or a target.

    `drag` names the parameter that it sets.
    """

    at: ArrayLike
    color: Color
    radius: float = 0.4
    style: PoseStyle = "robot"
    label: str = ""
    drag: str | None = None

    def _wire(self) -> dict[str, Any]:
        x, y, theta = finite("at", self.at)
        at = [round(float(c), 6) for c in (x, y, theta)]
        body = {"kind": "pose", "color": self.color, "radius": self.radius, "style": self.style, "at": at}
        return body | ({"label": self.label} if self.label else {}) | ({"drag": self.drag} if self.drag else {})


@dataclass(frozen=True, eq=False)
class Rays(Layer):
    """Beams from `origin` (2,) to `ends` (n, 2); those of `hits` (n,) end on a dot, all unless given."""

    origin: ArrayLike
    ends: ArrayLike
    color: Color = "measure"
    hits: ArrayLike | None = None

    def _wire(self) -> dict[str, Any]:
        ends = finite("ends", self.ends, 2)
        hits = np.ones(len(ends)) if self.hits is None else np.asarray(self.hits, dtype=np.float64)
        origin = [round(float(c), 4) for c in finite("origin", self.origin)]
        return {"kind": "rays", "color": self.color, "origin": origin, "ends": packed(ends), "hits": packed(hits)}


@dataclass(frozen=True, eq=False)
class Polyline(Layer):
    """A line through points (n, 2), `width` pixels wide."""

    at: ArrayLike
    color: Color
    width: float = 2.0
    dashed: bool = False

    def _wire(self) -> dict[str, Any]:
        line = {"kind": "polyline", "color": self.color, "width": self.width, "dashed": self.dashed}
        return {**line, "at": packed(finite("at", self.at, 2))}


@dataclass(frozen=True, eq=False)
class Segments(Layer):
    """Segments from `starts` (n, 2) to `ends` (n, 2): edges of a graph, pairs of points. `opacity` in ]0, 1]."""

    starts: ArrayLike
    ends: ArrayLike
    color: Color
    width: float = 1.5
    opacity: float = 1.0
    dashed: bool = False

    def _wire(self) -> dict[str, Any]:
        starts, ends = finite("starts", self.starts, 2), finite("ends", self.ends, 2)
        if len(starts) != len(ends):
            raise SceneError("ends", f"il faut autant de fins que de débuts : {len(ends)} pour {len(starts)}")
        line = {"kind": "segments", "color": self.color, "width": self.width, "dashed": self.dashed}
        return {**line, "opacity": self.opacity, "at": packed(np.hstack([starts, ends]))}


@dataclass(frozen=True, eq=False)
class Circles(Layer):
    """Circles of `radius` units around points (n, 2), filled lightly or as outlines."""

    at: ArrayLike
    radius: float
    color: Color
    filled: bool = True

    def _wire(self) -> dict[str, Any]:
        at = finite("at", self.at, 2)
        return {"kind": "circles", "color": self.color, "radius": self.radius, "filled": self.filled, "at": packed(at)}


@dataclass(frozen=True, eq=False)
class Ellipse(Layer):
    """The points within `sigmas` standard deviations of `mean` (2,), for a covariance (2, 2)."""

    mean: ArrayLike
    covariance: ArrayLike
    color: Color
    sigmas: float = 2.0

    def _wire(self) -> dict[str, Any]:
        mean, covariance = finite("mean", self.mean), finite("covariance", self.covariance, 2)
        variances, axes = np.linalg.eigh(covariance)
        small, large = self.sigmas * np.sqrt(np.maximum(variances, 0.0))
        angle = float(np.arctan2(axes[1, 1], axes[0, 1]))
        shape = [rounded(float(part), 5) for part in (*mean, large, small, angle)]
        return {"kind": "ellipse", "color": self.color, "at": shape}


@dataclass(frozen=True, eq=False)
class Labels(Layer):
    """Short texts centred on points (n, 2)."""

    at: ArrayLike
    texts: Sequence[str]
    color: Color = "ink"

    def _wire(self) -> dict[str, Any]:
        at = finite("at", self.at, 2)
        if len(at) != len(self.texts):
            raise SceneError("texts", f"il en faut un par place : {len(self.texts)} pour {len(at)}")
        return {"kind": "labels", "color": self.color, "texts": list(self.texts), "at": packed(at)}
