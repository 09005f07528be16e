"""What a module gives to take away: `fichiers/<name>.py` makes the files, served as one archive.

The archive is made at the first demand, the same bytes each time, and kept.
"""

from __future__ import annotations

from threading import Lock

from server.base.errors import NotFound
from server.base.files import reproducible_zip
from server.course import Course
from server.course.code import load_file


class Downloads:
    """Archives by module and name. Slow at first (about a second): call it in a thread."""

    def __init__(self, course: Course) -> None:
        self._course = course
        self._made: dict[tuple[str, str], bytes] = {}
        self._lock = Lock()

    def archive(self, module: str, name: str) -> bytes:
        """A ZIP whose files stand in one folder of that name. Raises NotFound."""
        course_module = self._course.modules.get(module)
        if course_module is None or name not in course_module.files:
            raise NotFound("Ce fichier n’existe pas.")
        with self._lock:
            if (module, name) not in self._made:
                files: dict[str, bytes] = load_file(course_module.files[name]).files()
                self._made[module, name] = reproducible_zip(name, files)
            return self._made[module, name]
