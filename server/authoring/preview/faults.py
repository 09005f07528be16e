"""What is wrong with one version of the files, looked for in a process of its own: formulas, figures, animations."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from server.authoring import objectives, shapes
from server.authoring.preview.reading import read_course_with_faults
from server.authoring.preview.supervising import PreviewSession
from server.base.files import write_atomically
from server.course import Problem, retrievals
from server.figures import lessons
from server.replays.faults import find_replay_faults as of_replays

#: It must not slow down what the author is looking at.
NICENESS = 15


def check_course_and_write_faults(session: PreviewSession) -> None:
    """Check the course and write its problems to the session's file."""
    os.nice(NICENESS)
    sys.dont_write_bytecode = True
    course = read_course_with_faults(session.course_folder, render=True)
    found = [
        *course.problems,
        *shapes.find_catalogue_faults(course),
        *objectives.find_objective_faults(course),
        *(fault for module in course.modules.values() for fault in retrievals.find_question_faults(module)),
        *lessons.find_drawing_faults(course),
        *of_replays(course),
    ]
    write_atomically(session.faults_file, json.dumps([[str(fault.path), fault.line, fault.message] for fault in found]))


def load_faults_or_known(session: PreviewSession, known: Iterable[Problem]) -> list[Problem]:
    """Return the problems found in this version, or `known` while the check is running."""
    try:
        return [*_parse_faults(session.faults_file)]
    except FileNotFoundError:
        return [*known]


def _parse_faults(path: Path) -> Iterator[Problem]:
    for place, line, message in json.loads(path.read_text(encoding="utf-8")):
        yield Problem(Path(place), line, message)
