"""Drawing a figure of the texts, here and at once: for the process that draws, for `balise check`, for a writer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from server.course import Course
from server.course.code import load_file
from server.course.models import Drawing, Problem

THEMES = ("light", "dark")


@dataclass(frozen=True)
class Drawn:
    """A drawing as a file, and its true size in inches."""

    picture: bytes
    size: tuple[float, float]


def draw(drawing: Drawing, theme: str, extension: str) -> Drawn:
    """Draw as "svg" or "png". Loads matplotlib. What the drawing function raises goes through."""
    return draw_with(drawing.path, drawing.function, drawing.size, theme, extension)


def draw_with(path: Path, function: str, size: tuple[float, float], theme: str, extension: str) -> Drawn:
    """The same, by what of a drawing changes its picture."""
    from graders.plotting import drawing as new_figure
    from graders.plotting import palette, to_bytes

    fill = getattr(load_file(path), function)
    with new_figure(theme) as figure:
        figure.set_size_inches(size)
        fill(figure, palette(theme))
        width, height = map(float, figure.get_size_inches())
        return Drawn(to_bytes(figure, extension), (width, height))


def size_fault(drawing: Drawing, drawn: Drawn) -> str:
    """What to change where the size is not the announced one: a page makes room for a figure before it is drawn."""
    if drawn.size == drawing.size:
        return ""
    width, height = drawn.size
    announced = f'"{drawing.name}": ({drawing.function}, "…", ({width:g}, {height:g}))'
    return f"la figure « {drawing.name} » change de taille ; annoncez-la dans FIGURES : {announced}"


def faults(course: Course, themes: Sequence[str] = THEMES) -> Iterator[Problem]:
    """Draw everything: what cannot be drawn, or is not of the announced size. Slow."""
    for module in course.modules.values():
        for drawing in module.drawings.values():
            try:
                pictures = [draw(drawing, theme, "svg") for theme in themes]
                message = next(filter(None, (size_fault(drawing, picture) for picture in pictures)), "")
            except Exception as error:  # whatever an author's function raises is reported with its place
                message = f"la figure « {drawing.name} » ne se dessine pas ({type(error).__name__}: {error})"
            if message:
                yield Problem(drawing.path, drawing.line, message)
