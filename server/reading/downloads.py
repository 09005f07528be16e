"""What a module gives to take away: `fichiers/<name>.py` makes the files, served as one archive.

The archive is made at the first demand, the same bytes each time, and kept.
"""

from __future__ import annotations

from server.base.concurrency import SingleFlight
from server.base.errors import NotFound
from server.base.files import reproducible_zip
from server.base.turns import out_of_turn
from server.course import Course
from server.course.code import import_file


class DownloadArchives:
    """Archives by module and name. One takes about a second to make."""

    def __init__(self, course: Course) -> None:
        self._course = course
        self._made: dict[tuple[str, str], bytes] = {}

    async def build_archive_once(self, module: str, name: str, once: SingleFlight) -> bytes:
        """Return the archive, made once for all who wait for it. Raises NotFound."""
        made = self._made.get((module, name))
        if made is None:
            async with out_of_turn():
                made = await once.run((DownloadArchives, module, name), lambda: self.build_archive(module, name))
        return made

    def build_archive(self, module: str, name: str) -> bytes:
        """Return a ZIP whose files stand in one folder of that name. Raises NotFound."""
        course_module = self._course.modules.get(module)
        if course_module is None or name not in course_module.files:
            raise NotFound("Ce fichier n’existe pas.")
        made = self._made.get((module, name))
        if made is None:
            files: dict[str, bytes] = import_file(course_module.files[name]).files()
            made = self._made[module, name] = reproducible_zip(name, files)
        return made
