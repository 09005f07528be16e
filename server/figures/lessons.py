"""Drawing a figure of the texts, here and at once: for the process that draws, for `balise check`, for a writer."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from server.course import Course
from server.course.code import import_file
from server.course.models import Drawing, Problem

if TYPE_CHECKING:
    from matplotlib.figure import Figure

THEMES = ("light", "dark")


@dataclass(frozen=True)
class RenderedDrawing:
    """A drawing as a file, and its true size in inches."""

    picture: bytes
    size: tuple[float, float]


def draw_lesson_figure(drawing: Drawing, theme: str, extension: str) -> RenderedDrawing:
    """Draw as "svg" or "png". Loads matplotlib. What the drawing function raises goes through."""
    return draw_figure_of_function(drawing.path, drawing.function, drawing.size, theme, extension)


def draw_figure_of_function(
    path: Path, function: str, size: tuple[float, float], theme: str, extension: str
) -> RenderedDrawing:
    """Draw the function of a file, as `draw_lesson_figure` does."""
    from graders.plotting import to_bytes

    with _open_drawn_figure(path, function, size, theme) as figure:
        return RenderedDrawing(to_bytes(figure, extension), _figure_size_inches(figure))


@contextmanager
def _open_drawn_figure(path: Path, function: str, size: tuple[float, float], theme: str) -> Iterator[Figure]:
    from graders.plotting import drawing, palette

    fill = getattr(import_file(path), function)
    with drawing(theme) as figure:
        figure.set_size_inches(size)
        fill(figure, palette(theme))
        yield figure


def _figure_size_inches(figure: Figure) -> tuple[float, float]:
    width, height = map(float, figure.get_size_inches())
    return width, height


def describe_size_fault(drawing: Drawing, size_inches: tuple[float, float]) -> str:
    """What to change where the size is not the announced one: a page makes room for a figure before it is drawn."""
    if size_inches == drawing.size:
        return ""
    width, height = size_inches
    announced = f'"{drawing.name}": ({drawing.function}, "…", ({width:g}, {height:g}))'
    return f"la figure « {drawing.name} » change de taille ; annoncez-la dans FIGURES : {announced}"


def find_drawing_faults(course: Course) -> Iterator[Problem]:
    """Draw everything: what cannot be drawn, or is not of the announced size. Slow.

    Each drawing is filled in every theme, for what its author's function says, and written as a file in one of them:
    the writing is matplotlib's, and most of the time.
    """
    for module in course.modules.values():
        for drawing in module.drawings.values():
            try:
                sizes = {
                    draw_lesson_figure(drawing, THEMES[0], "svg").size,
                    *(_draw_and_measure_inches(drawing, theme) for theme in THEMES[1:]),
                }
                message = next(filter(None, (describe_size_fault(drawing, size) for size in sizes)), "")
            except Exception as error:  # whatever an author's function raises is reported with its place
                message = f"la figure « {drawing.name} » ne se dessine pas ({type(error).__name__}: {error})"
            if message:
                yield Problem(drawing.path, drawing.line, message)


def _draw_and_measure_inches(drawing: Drawing, theme: str) -> tuple[float, float]:
    with _open_drawn_figure(drawing.path, drawing.function, drawing.size, theme) as figure:
        return _figure_size_inches(figure)
