"""The next edition of a module: all of it again under another name, to be changed while classes keep the first."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from graders import courses
from server.authoring.new import SkeletonRefused
from server.course.editions import MODULE_SLUG, next_edition_slug, parse_edition

IGNORED_FOLDERS = {"__pycache__"}


def copy_to_next_edition(module: str, course: Path) -> list[Path]:
    """Copies a module's folders beside them, its name replaced in names and texts; the files. Raises Refused, having
    written nothing."""
    if not MODULE_SLUG.fullmatch(module) or not (course / courses.CURRICULUM / module / "module.toml").is_file():
        raise SkeletonRefused(f"le module « {module} » n’existe pas dans {course}")
    made = _next_edition_slug(module)
    word = re.compile(rf"(?<![a-z0-9]){module}(?![a-z0-9])")
    files: dict[Path, bytes] = {}
    for room in (courses.CURRICULUM, courses.GRADERS):
        for path in _visible_files(course / room / module):
            place = course / room / made / path.relative_to(course / room / module)
            files[place.with_name(word.sub(made, place.name))] = _replace_module_name(path.read_bytes(), word, made)
    for path, content in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return list(files)


def _next_edition_slug(module: str) -> str:
    """The edition after the last that any course has."""
    family = parse_edition(module).family
    there = {path.name for room in courses.room_folders(courses.CURRICULUM) for path in room.iterdir()}
    return next_edition_slug(
        max((slug for slug in there | {module} if parse_edition(slug).family == family), key=parse_edition)
    )


def _visible_files(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.rglob("*")):
        hidden = any(part in IGNORED_FOLDERS or part.startswith(".") for part in path.relative_to(folder).parts)
        if path.is_file() and not hidden:
            yield path


def _replace_module_name(content: bytes, word: re.Pattern[str], made: str) -> bytes:
    try:
        return word.sub(made, content.decode("utf-8")).encode()
    except UnicodeDecodeError:  # a picture, an archive: no name is written there
        return content
