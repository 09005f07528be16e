"""The archives of modules: made when somebody asks, one at a time and beside everything else, then kept as files.

The figures are those of the service, which draws each once and shares out the turns: an archive asks for one at a time,
as a reader would who looks at them all.
"""

from __future__ import annotations

import asyncio
import logging
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from starlette.concurrency import run_in_threadpool

from server.base.errors import NotFound, Overloaded, WrongMoment
from server.base.files import write_atomically
from server.course import Course, Module
from server.course.editions import MODULE
from server.figures.drawing_requests import Theme
from server.figures.service import FigureService
from server.offline import site
from server.reading.downloads import DownloadArchives

log = logging.getLogger(__name__)

#: Whose turns the figures of archives are drawn in.
ADDRESS = "archive"
#: Seconds that an archive may take in all; a module of the course takes about thirty.
ARCHIVE_TIMEOUT = 900.0
#: Seconds between two tries for a figure, while there is no room in the queue.
RETRY_SECONDS = 5.0
ARCHIVE_NAME = re.compile(rf"(?P<module>{MODULE})-[0-9a-f]+\.zip")


@dataclass
class ArchiveInProgress:
    """An archive on its way: `done` pictures of `total`."""

    task: asyncio.Task[None]
    done: int = 0
    total: int = 0
    failed: bool = False


class OfflineArchives:
    """For one event loop. `folder` is this service's own."""

    def __init__(self, course: Course, figures: FigureService, downloads: DownloadArchives, folder: Path) -> None:
        self._course, self._figures, self._downloads, self._folder = course, figures, downloads, folder
        self._making: dict[str, ArchiveInProgress] = {}
        self._versions: dict[str, str] = {}
        self._one_at_a_time = asyncio.Lock()

    def module(self, slug: str) -> Module:
        """Raises NotFound, for a module without a text too: there would be nothing to take away."""
        module = self._course.modules.get(slug)
        if module is None or not module.lessons:
            raise NotFound("Ce module n’existe pas.")
        return module

    async def look(self, module: Module) -> Path | ArchiveInProgress | None:
        """The archive, or how far it is; None where nobody has asked for it yet."""
        path = await self._archive_path(module)
        return path if path.is_file() else self._making.get(module.slug)

    async def prepare(self, module: Module) -> None:
        """Has it made, if it is neither there nor on its way."""
        path = await self._archive_path(module)
        making = self._making.get(module.slug)
        if not path.is_file() and (making is None or making.failed):
            self._making[module.slug] = ArchiveInProgress(asyncio.create_task(self._make_archive(module, path)))

    async def file(self, module: Module) -> Path:
        """The archive. Raises NotNow while there is none."""
        found = await self.look(module)
        if isinstance(found, Path):
            return found
        raise WrongMoment("Cette archive n’est pas prête : demandez-la sur la page « Lire hors ligne » du module.")

    async def close(self) -> None:
        tasks = [making.task for making in self._making.values()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _archive_path(self, module: Module) -> Path:
        if module.slug not in self._versions:  # what is served does not change before a restart
            self._versions[module.slug] = await run_in_threadpool(site.archive_content_digest, module)
        return self._folder / f"{module.slug}-{self._versions[module.slug]}.zip"

    async def _make_archive(self, module: Module, path: Path) -> None:
        try:
            async with self._one_at_a_time, asyncio.timeout(ARCHIVE_TIMEOUT):
                pictures = await self._draw_pictures(module)
                made = await run_in_threadpool(site.build_archive_zip, self._course, module, pictures, self._downloads)
                await run_in_threadpool(_save_archive, path, module.slug, made)
        except Exception:  # whatever an author's drawing or replay raises: it is told to who asks, and noted here
            log.exception("the archive of %s could not be made", module.slug)
            self._making[module.slug].failed = True
        else:
            del self._making[module.slug]

    async def _draw_pictures(self, module: Module) -> site.Pictures:
        wanted = await run_in_threadpool(site.list_needed_pictures, module)
        making = self._making[module.slug]
        making.total = len(wanted)
        pictures = {}
        for name, theme in wanted:
            pictures[name, theme] = await self._draw_picture(module.slug, name, theme)
            making.done += 1
        return pictures

    async def _draw_picture(self, module: str, name: str, theme: Theme) -> bytes:
        while True:
            try:
                return await self._figures.draw_lesson_figure(module, name, theme, ADDRESS)
            except Overloaded:
                await asyncio.sleep(RETRY_SECONDS)


def _save_archive(path: Path, module: str, made: bytes) -> None:
    """All of it or nothing; earlier versions of the module's make room."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    write_atomically(path, made)
    for other in path.parent.iterdir():
        kept = ARCHIVE_NAME.fullmatch(other.name)
        if kept and kept["module"] == module and other != path:
            with suppress(OSError):
                other.unlink()
