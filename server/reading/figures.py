"""The drawings of the texts, made when they are looked at. The latest ones are kept."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Literal

from starlette.concurrency import run_in_threadpool

from server.base.errors import NotFound
from server.course import Course
from server.course.code import load_file
from server.course.models import Drawing, Problem

Theme = Literal["light", "dark"]
Key = tuple[str, str, Theme]
NO_FIGURE = "Cette figure n’existe pas."
KEPT_BYTES = 32 << 20
THEMES: tuple[Theme, ...] = ("light", "dark")


class Drawings:
    """Draws in SVG and remembers, up to `kept` bytes. For one event loop."""

    def __init__(self, course: Course, kept: int = KEPT_BYTES) -> None:
        self._course = course
        self._kept = kept
        self._drawn: OrderedDict[Key, bytes] = OrderedDict()
        self._lock = Lock()
        self._turn = asyncio.Semaphore(1)

    async def picture(self, module: str, name: str, theme: Theme) -> bytes:
        """The picture. Whoever waits for one to be drawn holds no thread; a class draws it once. Raises NotFound."""
        found = self._remembered((module, name, theme))
        if found is not None:
            return found
        async with self._turn:
            return await run_in_threadpool(self.svg, module, name, theme)

    def svg(self, module: str, name: str, theme: Theme) -> bytes:
        """The same, at once. Slow at first (hundreds of ms). Raises NotFound."""
        key = (module, name, theme)
        found = self._course.modules.get(module)
        if found is None or name not in found.drawings:
            raise NotFound(NO_FIGURE)
        remembered = self._remembered(key)
        if remembered is not None:
            return remembered
        return self._remember(key, draw(found.drawings[name], theme, "svg").picture)

    def _remembered(self, key: Key) -> bytes | None:
        with self._lock:
            if key in self._drawn:
                self._drawn.move_to_end(key)
            return self._drawn.get(key)

    def _remember(self, key: Key, picture: bytes) -> bytes:
        with self._lock:
            self._drawn[key] = picture
            while len(self._drawn) > 1 and sum(map(len, self._drawn.values())) > self._kept:
                self._drawn.popitem(last=False)
        return picture


@dataclass(frozen=True)
class Drawn:
    """A drawing as a file, and its true size in inches."""

    picture: bytes
    size: tuple[float, float]


def draw(drawing: Drawing, theme: str, extension: str) -> Drawn:
    """Draw as "svg" or "png". Loads matplotlib. What the drawing function raises goes through."""
    from graders.plotting import drawing as new_figure
    from graders.plotting import palette, to_bytes

    function = getattr(load_file(drawing.path), drawing.function)
    with new_figure(theme) as figure:
        figure.set_size_inches(drawing.size)
        function(figure, palette(theme))
        width, height = map(float, figure.get_size_inches())
        return Drawn(to_bytes(figure, extension), (width, height))


def size_fault(drawing: Drawing, drawn: Drawn) -> str:
    """What to change where the size is not the announced one: a page makes room for a figure before it is drawn."""
    if drawn.size == drawing.size:
        return ""
    width, height = drawn.size
    announced = f'"{drawing.name}": ({drawing.function}, "…", ({width:g}, {height:g}))'
    return f"la figure « {drawing.name} » change de taille ; annoncez-la dans FIGURES : {announced}"


def faults(course: Course, themes: Sequence[Theme] = THEMES) -> Iterator[Problem]:
    """Draw everything: what cannot be drawn, or is not of the announced size. Slow."""
    for module in course.modules.values():
        for drawing in module.drawings.values():
            try:
                drawn = [draw(drawing, theme, "svg") for theme in themes]
                message = next(filter(None, (size_fault(drawing, one) for one in drawn)), "")
            except Exception as error:  # whatever an author's function raises is reported with its place
                message = f"la figure « {drawing.name} » ne se dessine pas ({type(error).__name__}: {error})"
            if message:
                yield Problem(drawing.path, drawing.line, message)
