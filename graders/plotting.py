"""The style of the figures, light and dark. Never imported on the path of a verdict: it loads matplotlib."""

from __future__ import annotations

import importlib
import io
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

#: The module that draws declared exercises: their kinds are named « declared_… ».
DECLARED = "graders.core.declared.figures"
EXPECTED = "#2a78c8"
OBTAINED = "#d9622b"
THIRD = "#3d9a5f"


@dataclass(frozen=True)
class Palette:
    """The colours of a drawing on one theme's paper, each but `faint` readable there as text (contrast above 4.5).

    By convention the truth is blue, an estimate orange, a measurement green; walls are ink, what is unknown is faint.
    """

    ink: str
    faint: str
    paper: str
    truth: str
    estimate: str
    measure: str
    alert: str
    second: str
    _shades: tuple[str, ...]

    @cached_property
    def ramp(self) -> Colormap:
        """For densities: from the paper (nothing) through the colour of the truth to the strongest contrast."""
        return LinearSegmentedColormap.from_list("balise", self._shades)


_THEMES = {
    "light": Palette(
        ink="#1d2733",
        faint="#c9d1da",
        paper="#ffffff",
        truth="#1f6dbd",
        estimate="#c4521a",
        measure="#2a7f4b",
        alert="#b3202c",
        second="#7747c2",
        _shades=("#ffffff", "#a9cdf0", "#3f8ad6", "#14528f", "#0b2d52"),
    ),
    "dark": Palette(
        ink="#e4e9ef",
        faint="#4a5563",
        paper="#171c23",
        truth="#6fb1f2",
        estimate="#f2945e",
        measure="#6cc48d",
        alert="#ff7b86",
        second="#bda0f5",
        _shades=("#171c23", "#17456f", "#2f82cc", "#86c1f7", "#eaf4ff"),
    ),
}
THEMES = tuple(_THEMES)


def palette(theme: str) -> Palette:
    """The colours of a theme, "light" or "dark"."""
    return _THEMES[theme]


# matplotlib is not thread-safe: one drawing at a time.
_LOCK = threading.RLock()


def _style(theme: str) -> Any:
    colours = palette(theme)
    ink, faint, paper = colours.ink, colours.faint, colours.paper
    return {
        "figure.facecolor": paper,
        "axes.facecolor": paper,
        "savefig.facecolor": paper,
        "text.color": ink,
        "axes.labelcolor": ink,
        "axes.titlecolor": ink,
        "axes.edgecolor": faint,
        "axes.titlesize": 11,
        "xtick.color": ink,
        "ytick.color": ink,
        "grid.color": faint,
        "grid.linewidth": 0.5,
        "axes.grid": True,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "legend.fontsize": 9,
        "font.size": 9.5,
        "font.family": "DejaVu Sans",
        "axes.formatter.use_locale": False,
        "svg.fonttype": "path",
        "svg.hashsalt": "balise",
    }


@contextmanager
def drawing(theme: str = "light") -> Iterator[Figure]:
    """A new figure in the given theme ("light" or "dark"); expected values are blue, obtained ones orange."""
    with _LOCK, mpl.rc_context(_style(theme)):
        yield Figure(figsize=(6.4, 4.0), layout="constrained")


def ink_of(axes: Axes) -> str:
    """The colour of text in the current theme, for what stands for itself rather than for a value."""
    return str(axes.xaxis.label.get_color())


class _FrenchTicks(ScalarFormatter):
    """Ticks with a decimal comma, whatever the locale of the machine."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return super().__call__(x, pos).replace(".", ",")


def _write_ticks_in_french(figure: Figure) -> None:
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if type(axis.get_major_formatter()) is ScalarFormatter:
                axis.set_major_formatter(_FrenchTicks())


def to_bytes(figure: Figure, extension: str) -> bytes:
    """The figure as a file, "svg" or "png", to be asked for inside `drawing`. Reproducible: no date in it."""
    _write_ticks_in_french(figure)
    buffer = io.BytesIO()
    metadata = {"Date": None} if extension == "svg" else None
    figure.savefig(buffer, format=extension, metadata=metadata, dpi=144)
    return buffer.getvalue()


def counterexample(exercise: str, data: dict[str, Any], *, theme: str = "light", extension: str = "svg") -> bytes:
    """The figure whose data a verdict of this exercise left, as a "svg" or "png" file.

    `FIGURES` of its module names what draws each "kind" of data, and what that shows in words, which `server.course`
    reads; the figures of older courses come without words.
    """
    own = f"graders.{exercise.replace('/', '.')}.figures"
    module = importlib.import_module(DECLARED if data["kind"].startswith("declared_") else own)
    entry = module.FIGURES[data["kind"]]
    draw = entry if callable(entry) else entry[0]
    with drawing(theme) as figure:
        draw(figure, data)
        return to_bytes(figure, extension)
