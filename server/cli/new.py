"""`balise new KIND NAME`: a skeleton that works, in the folder of a course."""

import os
from argparse import Namespace
from pathlib import Path

from graders.courses import COURSES, REPOSITORY
from server.authoring import editions, new
from server.cli import CannotRun
from server.cli.authors import EDITION


def run(arguments: Namespace) -> int:
    course: Path = arguments.into or new.default_course_folder(arguments.name)
    try:
        files = _written(arguments.kind, arguments.name, course)
    except new.NameRefused as refused:
        raise CannotRun(f"{refused}.") from refused
    except OSError as error:
        raise CannotRun(f"impossible d’écrire dans « {course} » : {error.strerror}.") from error
    for path in files:
        print(os.path.relpath(path))
    print("\n" + "\n".join(_next(arguments.kind, arguments.name, course)))
    return 0


def _written(kind: str, name: str, course: Path) -> list[Path]:
    return editions.copy_to_next_edition(name, course) if kind == EDITION else new.write_skeleton(kind, name, course)


def _next(kind: str, name: str, course: Path) -> list[str]:
    """What one does then, as one types it."""
    where = "" if course.resolve() in (REPOSITORY, *COURSES.folders) else f" --course {os.path.relpath(course)}"
    own = course.resolve() == REPOSITORY  # this repository may hold several modules
    lines = [f"Voir : balise preview {name.partition('/')[0] if own else os.path.relpath(course)}"]
    if kind not in {"module", "page", "replay", EDITION}:
        lines.append(f"Vérifier : balise check {name}{where}")
    return lines
