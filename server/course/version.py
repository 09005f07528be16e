"""The version of an exercise: a digest of all that can change a verdict, and of nothing else.

In it: the closure of its grader's imports (`closure.py`), from where it is described and from the class that grades;
the solution, the catalogued mistakes and any data of its grader's folder; of the course, the questions of an exercise
without code, the kit that code finds, and of `exercise.toml` the kind, the functions asked for and the limits.

Not in it: what is read beside the code (statement, hints, starter, title), what is drawn from a verdict (`figures.py`,
`graders/plotting.py`), what only tries the grader (the specimens, the marks of equivalent alterations); nor what every
exercise shares and no file of the course says: the sandbox, Python, NumPy.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from graders.core.contract.kits import Files, find_available_kits
from server.base.files import digest_files, walk_files
from server.course.closure import ImportGraph
from server.course.schemas import ExerciseFile

GRADER = "grader"
COURSE_FILES = ("misconceptions.toml", "questions.toml")
SPECIMENS = "specimens"
MISTAKES = "misconceptions"
NOT_DATA = {".py", ".md"}
EQUIVALENTS = "equivalents.toml"


def compute_exercise_version(
    imports: ImportGraph, code: Sequence[Path], folder: Path, card: ExerciseFile, grader: object, kit: str
) -> str:
    """See the head of this file. `folder` is the exercise's, in the course; `code` are the folders that hold graders;
    `kit` is the name of what its programs find."""
    return digest_files(iterate_grading_files(imports, code, folder, card, grader, kit), _serialize_graded_fields(card))


def iterate_grading_files(
    imports: ImportGraph, code: Sequence[Path], folder: Path, card: ExerciseFile, grader: object, kit: str
) -> Iterator[tuple[str, Path]]:
    """The files that decide of a verdict, each with a name that tells no place on this machine."""
    module = folder.parents[1].name
    graders = grader_folder(code, module, folder.name)
    described = imports.imported_files(f"graders.{module}.{folder.name}.{GRADER}")
    yield from sorted((described | imports.imported_files(type(grader).__module__)).items())
    yield from (named for named in walk_files(GRADER, graders) if _affects_verdict(named[1].relative_to(graders)))
    if card.kind == "code":
        yield from _kit_files(find_available_kits(folder.parents[1])[kit])
    else:
        yield from ((name, folder / name) for name in COURSE_FILES if (folder / name).is_file())


def grader_folder(code: Sequence[Path], module: str, slug: str) -> Path:
    """The folder that grades an exercise, or would."""
    folders = [root / "graders" / module / slug for root in code]
    return next((folder for folder in folders if folder.is_dir()), folders[0])


def _kit_files(files: Files) -> Iterator[tuple[str, Path]]:
    """A kit of one file is known without its name, which is the module's."""
    yield from ((f"kit/{place}" if len(files) > 1 else "kit", path) for place, path in files.items())


def _serialize_graded_fields(card: ExerciseFile) -> bytes:
    functions = [(function.name, function.signature) for function in card.functions]
    return json.dumps([card.kind, functions, card.limits.overridden_fields()], sort_keys=True).encode()


def _affects_verdict(relative: Path) -> bool:
    """Whether an unimported file of a grader's folder can change a verdict."""
    if relative.parts[0] in {SPECIMENS, MISTAKES}:
        return relative.parts[0] == MISTAKES
    return relative.name == "solution.py" or (relative.suffix not in NOT_DATA and relative.name != EQUIVALENTS)
