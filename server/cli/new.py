"""`balise new KIND NAME`: a skeleton that works, in the folder of a course."""

import os
from argparse import Namespace
from pathlib import Path

from graders.courses import COURSES, REPOSITORY
from server.authoring import editions, new
from server.authoring.drafts import DECLARED, write_drafts
from server.cli import CommandError
from server.cli.authors import EDITION
from server.studio.import_drafts import ImportRefused
from server.studio.imports import read_drafts


def run(arguments: Namespace) -> int:
    course: Path = arguments.into or new.default_course_folder(arguments.name)
    if arguments.source is not None:
        return _import_drafts(arguments.kind, arguments.name, arguments.source, course)
    try:
        files = _create_files_of_kind(arguments.kind, arguments.name, course)
    except new.SkeletonRefused as refused:
        raise CommandError(f"{refused}.") from refused
    except OSError as error:
        raise CommandError(f"impossible d’écrire dans « {course} » : {error.strerror}.") from error
    for path in files:
        print(os.path.relpath(path))
    print("\n" + "\n".join(_next_steps(arguments.kind, arguments.name, course)))
    return 0


def _import_drafts(kind: str, name: str, source: Path, course: Path) -> int:
    """Write the drafts of a file; say of each what was understood, what to look at, and what was left."""
    if kind != DECLARED:
        raise CommandError("« --from » va avec « declared ».")
    try:
        for draft, files in write_drafts(read_drafts(source.name, source.read_bytes()), name, course):
            print(f"{draft.title} : {len(draft.understood)} cas lus" + ("" if files else ", rien n’est écrit"))
            for words, places in (("à regarder", draft.to_look_at), ("laissé", draft.left)):
                print("".join(f"  {words} : {place}\n" for place in places), end="")
            print("".join(f"  {os.path.relpath(path)}\n" for path in files), end="")
    except (ImportRefused, new.SkeletonRefused) as refused:
        raise CommandError(f"{refused}.") from refused
    except OSError as error:
        raise CommandError(f"« {error.filename or source} » : {error.strerror}.") from error
    print("\n" + "\n".join(_next_steps(kind, name, course)))
    return 0


def _create_files_of_kind(kind: str, name: str, course: Path) -> list[Path]:
    return editions.copy_to_next_edition(name, course) if kind == EDITION else new.write_skeleton(kind, name, course)


def _next_steps(kind: str, name: str, course: Path) -> list[str]:
    """What one does then, as one types it."""
    where = "" if course.resolve() in (REPOSITORY, *COURSES.folders) else f" --course {os.path.relpath(course)}"
    own = course.resolve() == REPOSITORY  # this repository may hold several modules
    lines = [f"Voir : balise preview {name.partition('/')[0] if own else os.path.relpath(course)}"]
    if kind not in {"module", "page", "replay", EDITION}:
        lines.append(f"Vérifier : balise check {name}{where}")
    return lines
