"""The retrieval questions of a module: `rappels/<lesson>.py`, one function for each, run when a question is asked."""

from __future__ import annotations

import ast
import re
import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from server.course import toml_file
from server.course.code import import_file, parse_python
from server.course.models import CourseFault, Module, Problem

if TYPE_CHECKING:  # loaded where a question is drawn: a verdict of code needs none
    from graders.core.answers.retrieval import DrawQuestion, RetrievalQuestion

FOLDER = "rappels"
QUESTION_NAME = re.compile(r"[a-z0-9]+(?:_[a-z0-9]+)*")
#: Draws of each question that `balise check` looks at.
CHECKED_DRAWS = 40


def list_question_files(folder: Path, problems: list[Problem]) -> Mapping[str, Path]:
    """Return the files of a module's questions by the questions' names, `lesson/question`. A fault is noted."""
    names: dict[str, Path] = {}
    for path in sorted((folder / FOLDER).glob("[!_.]*.py")):
        try:
            tree = parse_python(toml_file.read_text(path), path)
        except CourseFault as fault:
            problems.append(fault.problem)
            continue
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and QUESTION_NAME.fullmatch(node.name):
                names[f"{path.stem.replace('_', '-')}/{node.name}"] = path
    return names


def draw_question(module: Module, name: str, seed: int) -> RetrievalQuestion:
    """Return a question with the numbers of a seed. Raises KeyError for a name that is not in `module.retrievals`."""
    from graders.core.answers.retrieval import draw_question

    return draw_question(_load_draw_function(module.retrievals[name], name), seed)


def _load_draw_function(path: Path, name: str) -> DrawQuestion:
    function: DrawQuestion = getattr(import_file(path), name.partition("/")[2])
    return function


def find_question_faults(module: Module) -> Iterator[Problem]:
    """Yield a problem for each question that cannot be drawn, or whose answers are confused, with its line."""
    from graders.core.answers.retrieval import draw_question, find_question_fault

    pages = {lesson.slug for lesson in module.lessons}
    for name, path in module.retrievals.items():
        try:
            function = _load_draw_function(path, name)
            line = function.__code__.co_firstlineno
            found = (find_question_fault(draw_question(function, seed)) for seed in range(CHECKED_DRAWS))
            fault = next(filter(None, found), "")
        except Exception as error:  # whatever an author's function raises is reported with its place
            lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
            yield Problem(path, lines[-1] if lines else None, f"question « {name} » : {type(error).__name__}: {error}")
            continue
        if fault:
            yield Problem(path, line, f"question « {name} » : {fault}")
        if name.partition("/")[0] not in pages:
            yield Problem(path, None, f"aucune page ne se nomme « {name.partition('/')[0]} »")
