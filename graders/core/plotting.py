"""The style of the figures, light and dark. Never imported on the path of a verdict: it loads matplotlib."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

EXPECTED = "#2a78c8"
OBTAINED = "#d9622b"
THIRD = "#3d9a5f"

_THEMES = {
    "light": {"ink": "#1d2733", "faint": "#c9d1da", "paper": "#ffffff"},
    "dark": {"ink": "#e4e9ef", "faint": "#4a5563", "paper": "#171c23"},
}


# matplotlib is not thread-safe: one drawing at a time.
_LOCK = threading.RLock()


def _style(theme: str) -> Any:
    colours = _THEMES[theme]
    ink, faint, paper = colours["ink"], colours["faint"], colours["paper"]
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
