"""Drawing in a template: matplotlib without a window, and the figures of a program as PNG files.

`render_open_figures` bounds honest programs only: a hostile one answers whatever it wants, and the trusted side
re-encodes it.
"""

from __future__ import annotations

import datetime
import importlib.util
import io
import os
import subprocess
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

import numpy as np

from .wire_values import Array

#: Name of the function that returns a program's figures; Python code cannot define such a name.
FIGURES = "<figures>"
MAX_FIGURES, MAX_BYTES, MAX_PIXELS = 4, 1 << 20, 2_000_000
#: Points an inch of a figure that is shown: one and a half times matplotlib's own, for fine screens.
RESOLUTION = 150.0
#: No folder can be made there: matplotlib keeps nothing on this machine.
_NOWHERE = "/dev/null/matplotlib"


def configure_matplotlib() -> None:
    """Before anything else imports matplotlib: no configuration, no cache, no font but its own, no window."""
    package = importlib.util.find_spec("matplotlib")
    assert package
    assert package.origin
    os.environ["MATPLOTLIBRC"] = os.path.join(os.path.dirname(package.origin), "mpl-data", "matplotlibrc")
    os.environ["MPLBACKEND"] = "Agg"
    import matplotlib

    matplotlib.get_cachedir = matplotlib.get_configdir = lambda: _NOWHERE
    matplotlib.set_loglevel("ERROR")
    with _restrict_to_bundled_fonts(os.path.join(matplotlib.get_data_path(), "fonts", "ttf")):
        importlib.import_module("matplotlib.font_manager")
    matplotlib.rcParams["savefig.dpi"] = RESOLUTION
    with suppress(ModuleNotFoundError):  # behind the walls, a child finds the rest of it at the first need
        importlib.import_module("scipy.sparse.linalg")


@contextmanager
def _restrict_to_bundled_fonts(folder: str) -> Iterator[None]:
    """matplotlib looks through the fonts of the machine, which a child cannot read, with a command and a thread.

    The metrics of the fonts that printers have are for their files alone; reading them takes as long as all the others.
    """
    walk, timer, check_output = os.walk, threading.Timer, subprocess.check_output

    def refuse(*_: object, **__: object) -> NoReturn:
        raise FileNotFoundError

    def no_timer(*_: object) -> NoReturn:
        raise RuntimeError

    os.walk = lambda top, *rest: walk(top, *rest) if str(top).startswith(folder) else iter(())
    threading.Timer, subprocess.check_output = no_timer, refuse  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        os.walk, threading.Timer, subprocess.check_output = walk, timer, check_output  # type: ignore[misc]


def warm_up() -> None:
    """Draws once what most programs draw, so that fonts and formulas are ready."""
    pyplot: Any = sys.modules["matplotlib.pyplot"]
    _, axes = pyplot.subplots(figsize=(3, 2))
    axes.plot([0, 1], [1, 0], "o-", label="$x$")
    axes.imshow(np.eye(2))
    axes.set_title(r"$\theta_0$")
    axes.legend()
    dated = pyplot.figure(figsize=(3, 2)).add_subplot()
    dated.plot([datetime.date(2000, 1, 1)], [0])  # looks for the time zones, and finds none
    render_open_figures()
    pyplot.close("all")


def is_loaded() -> bool:
    """Whether matplotlib itself is loaded, and no stand-in of it (`drawing_stand_ins`)."""
    return "get_fignums" in vars(sys.modules.get("matplotlib.pyplot", sys))


def render_open_figures() -> tuple[Array, ...]:
    """The open figures, the first ones at most; says so where that leaves some out, and what drawing them warns of."""
    pyplot: Any = sys.modules["matplotlib.pyplot"]
    opened = pyplot.get_fignums()
    if len(opened) > MAX_FIGURES:
        print(f"({len(opened)} figures sont ouvertes : seules les {MAX_FIGURES} premières sont montrées.)")
    with warnings.catch_warnings(record=True) as heard:
        files = [_render_png_within_bounds(pyplot.figure(number)) for number in opened[:MAX_FIGURES]]
    for warning in dict.fromkeys(f"{record.category.__name__}: {record.message}" for record in heard):
        print(warning)
    return tuple(np.frombuffer(file, np.uint8) for file in files)


def _render_png_within_bounds(figure: Any) -> bytes:
    """The figure at its usual resolution, or at a lower one that keeps it within the bounds."""
    width, height = figure.get_size_inches()
    resolution = min(RESOLUTION, (MAX_PIXELS / max(width * height, 1e-9)) ** 0.5 * 0.99)
    while True:
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=resolution)
        if buffer.tell() <= MAX_BYTES:
            return buffer.getvalue()
        resolution *= 0.6
