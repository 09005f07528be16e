"""Skeletons: files that work as they stand, with comments that teach, and names that are said once."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from graders import courses
from server.base.version import VERSION
from server.course import toml_file
from server.course.editions import MODULE_SLUG
from server.course.kinds import KINDS as LESSONS
from server.course.library import read_front_matter
from server.course.models import CourseFault
from server.course.schemas import ExerciseFile
from server.course.service import EXERCISE_SLUG
from server.text.markup.text import SLUG as PAGE_SLUG

SKELETONS = Path(__file__).with_name("skeletons")
COURSE = "course"
MODULE = "module"
ORDER_STEP = 10
FOLDERS = {kind.folder: kind.name for kind in LESSONS}


class SkeletonRefused(Exception):
    """A name that cannot be given; the message is French, and says what to write."""


@dataclass(frozen=True)
class SkeletonName:
    """What a skeleton is made for: `folder` is that of a page's kind."""

    module: str
    slug: str = ""
    folder: str = ""


def write_skeleton(kind: str, name: str, course: Path) -> list[Path]:
    """Writes a skeleton into the folder of a course; the files, in the order of reading. Raises Refused, having written
    nothing, where a name does not do or something stands there already."""
    read = _parse_module_name(name) if kind == MODULE else _parse_skeleton_name(kind, name)
    home = course / courses.CURRICULUM / read.module
    if kind == MODULE:
        _check_module_free(read.module, course)
    elif not (home / "module.toml").is_file():
        raise SkeletonRefused(
            f"le module « {read.module} » n’existe pas dans {course} : « balise new module {read.module} »"
        )
    words = _placeholder_values(kind, read, home, course)
    skeletons = [SKELETONS / kind]
    if kind == MODULE and not (course / courses.CURRICULUM).is_dir():
        skeletons.append(SKELETONS / COURSE)
    files = {path: text for skeleton in skeletons for path, text in _render_skeleton(skeleton, words, course)}
    for path in [path for path in files if path.name == "__init__.py" and path.exists()]:
        del files[path]
    taken = [path for path in files if path.exists()]
    taken += home.glob(f"*/{read.slug}.md") if kind == "page" else ()
    if taken:
        raise SkeletonRefused(f"il y a déjà quelque chose ici : {taken[0]}")
    for path, text in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return list(files)


def _parse_module_name(name: str) -> SkeletonName:
    if not MODULE_SLUG.fullmatch(name):
        raise SkeletonRefused(f"« {name} » : un module se nomme par des minuscules puis un nombre, comme « l19 »")
    return SkeletonName(name)


def _check_module_free(module: str, course: Path) -> None:
    for room in courses.room_folders(courses.CURRICULUM):
        if (room / module).is_dir() and room != course / courses.CURRICULUM:
            raise SkeletonRefused(f"un autre cours a déjà un module « {module} » : {room / module}")


def _parse_skeleton_name(kind: str, name: str) -> SkeletonName:
    module, *folders, slug = name.split("/") if "/" in name else ("", name)
    if not MODULE_SLUG.fullmatch(module):
        raise SkeletonRefused(f"« {name} » : dites aussi le module, comme « l19/{slug} »")
    if kind == "page":
        folder = folders[0] if folders else LESSONS[0].folder
        if folder not in FOLDERS or len(folders) > 1:
            raise SkeletonRefused(f"« {'/'.join(folders)} » : les dossiers de pages sont {', '.join(FOLDERS)}")
        return SkeletonName(
            module,
            _validate_slug(slug, re.compile(PAGE_SLUG), "des minuscules sans accent, chiffres et tirets"),
            folder,
        )
    if folders:
        raise SkeletonRefused(f"« {name} » : un module et un nom, comme « {module}/{slug} »")
    slug = slug.replace("-", "_") if kind == "replay" else slug
    return SkeletonName(module, _validate_slug(slug, EXERCISE_SLUG, "des minuscules sans accent, chiffres et « _ »"))


def _validate_slug(slug: str, pattern: re.Pattern[str], words: str) -> str:
    if not pattern.fullmatch(slug) or slug[0].isdigit():
        raise SkeletonRefused(f"« {slug} » : un nom est fait de {words}, et commence par une lettre")
    return slug


def _placeholder_values(kind: str, name: SkeletonName, home: Path, course: Path) -> dict[str, str]:
    """Return the values of a skeleton's placeholders."""
    slug = re.sub(r"[^a-z0-9]+", "-", course.resolve().name.lower()).strip("-") or "cours"
    slug = slug if slug.startswith("cours") else f"cours-{slug}"
    return {
        "__MODULE__": name.module,
        "__NUMBER__": name.module.upper(),
        "__SLUG__": name.slug,
        "__NAME__": name.slug.replace("_", "-"),
        "__FOLDER__": name.folder,
        "__ORDER__": str(max([0, *_find_taken_orders(kind, name, home)]) + ORDER_STEP),
        "__COURSE__": slug,
        "__PACKAGE__": slug.replace("-", "_"),
    }


def _find_taken_orders(kind: str, name: SkeletonName, home: Path) -> Iterator[int]:
    """The places that are taken where the new one goes, by what can be read."""
    pages = kind == "page"
    for path in home.glob(f"{name.folder}/*.md" if pages else "exercices/*/exercise.toml"):
        try:
            yield read_front_matter(path).order if pages else toml_file.read_toml(path, ExerciseFile).order
        except CourseFault:
            continue


def _render_skeleton(skeleton: Path, words: dict[str, str], course: Path) -> Iterator[tuple[Path, str]]:
    mark = re.compile("|".join(words))
    for path in sorted(skeleton.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            place, text = (
                mark.sub(lambda found: words[found[0]], text)
                for text in (path.relative_to(skeleton).as_posix(), path.read_text(encoding="utf-8"))
            )
            yield course / place, _stamp_version(place, text)


def _stamp_version(place: str, text: str) -> str:
    """Write the version of Balise into a file of settings, a page's heading, a replay; not into students' programs."""
    line = f"# Écrit par « balise new », version {VERSION}.\n"
    if place.endswith(".md"):
        return text.replace("+++\n", f"+++\n{line}", 1) if text.startswith("+++\n") else text
    return line + text if place.endswith(".toml") or "/rejeux/" in place else text


def default_course_folder(name: str) -> Path:
    """The course that a new name goes to where none is said: its module's, or the folder where one stands."""
    folder = courses.module_folder(name.split("/", maxsplit=1)[0])
    return folder.parents[1] if folder.is_dir() else Path.cwd()
