"""What classes' attempts teach about an exercise: failures alike that no misconception names, for who writes it.

Groups are those of `server.behaviour`; a program is shown without what tells who wrote it, and without what its
behaviour does not need.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy.orm import Session

from graders.core.code.behaviour import Behaviour, BehaviourObserver
from graders.core.code.folder import MISCONCEPTIONS
from graders.core.code.grading import CodeGrader
from graders.core.code.stored_answers import same_answers
from graders.core.compare import words as render
from graders.core.compare.slips import SLIPS
from graders.core.compare.told_apart import value_text_pair
from graders.core.syntax_trees import parse_source
from server.behaviour import place_queries, repository
from server.behaviour.export import add_unread_guard, anonymise_program, format_catalogue_entry, make_misconception_id
from server.behaviour.limits import tighten_limits
from server.behaviour.schemas import GroupDescription
from server.course.models import Exercise
from server.grading.sandbox_grader import SandboxGrader

#: How many smaller programs are tried, each launched twice.
MAX_SHRINK_TRIES = 60
PLACEHOLDER = "À DIRE"


@dataclass(frozen=True)
class UnexplainedGroup:
    """A group: in how many attempts, by how many students, how it fails, what a teacher calls it if one does.

    `source` is its shortest program, `names` those of its author; `version` is the exercise's, when it was asked.
    `changes` are the kinds of changes that mend its programs, each with how many.
    """

    group_id: str
    attempts: int
    students: int
    functions: tuple[str, ...]
    example: dict[str, Any] | None
    version: str
    description: GroupDescription | None
    source: bytes
    names: tuple[str, ...]
    changes: tuple[tuple[str, int], ...] = ()


class MisconceptionWriteError(Exception):
    """A misconception that cannot be written; the message is French."""


def load_unexplained_groups(db: Session, exercise: str, most: int) -> list[UnexplainedGroup]:
    """The most frequent first, then those that the same change mends."""
    groups = [
        found
        for row in repository.list_unexplained_groups(db, exercise, most)
        if (found := _load_unexplained_group(db, *row)) is not None
    ]
    first = {change: place for place, change in reversed(list(enumerate(map(most_frequent_change, groups)))) if change}
    return sorted(groups, key=lambda group: first.get(most_frequent_change(group), groups.index(group)))


def most_frequent_change(found: UnexplainedGroup) -> str:
    """Return the kind of change that mends most programs of a group; "" where none is known."""
    return found.changes[0][0] if found.changes else ""


def _load_unexplained_group(db: Session, group_id: str, attempts: int, students: int) -> UnexplainedGroup | None:
    group, program = repository.find_group(db, group_id), repository.load_shortest_program(db, group_id)
    if group is None or program is None:
        return None
    name = repository.find_latest_behaviour_name(db, group_id)
    return UnexplainedGroup(
        group_id,
        attempts,
        students,
        tuple(group.functions),
        group.example,
        group.exercise_version,
        GroupDescription(name.title, name.explanation, name.question) if name else None,
        program[0],
        tuple(word for name in program[1] for word in re.findall(r"[^\W_]+", name)),
        tuple(place_queries.count_mending_changes(db, group_id)),
    )


def minimise_program(found: UnexplainedGroup, exercise: Exercise, grader: SandboxGrader | None) -> str:
    """Its program, as small as it can be made where there is a sandbox. Raises Invalid for one that cannot be read."""
    bare = anonymise_program(found.source, found.names)
    if grader is None or not isinstance(exercise.grader, CodeGrader):
        return bare
    observer = BehaviourObserver(exercise.grader, exercise.version)

    def behaviour(text: str) -> Behaviour:
        return observer.observe(text.encode(), grader.program_starter(exercise.id, tighten_limits(exercise.policy)))

    wanted = behaviour(bare)
    if not wanted.shows_mistake:
        return bare
    return shrink_program(bare, lambda text: same_answers(behaviour(text).answers, wanted.answers))


def shrink_program(program: str, alike: Callable[[str], bool], tries: int = MAX_SHRINK_TRIES) -> str:
    """The program without the statements, and the branches, that may go while it stays `alike`."""
    place, changed = 0, False
    for _ in range(tries):
        smaller = next(itertools.islice(_iter_smaller_programs(program), place, None), None)
        if smaller is None and not changed:
            break
        if smaller is None:  # what went may have been all that needed something else
            place, changed = 0, False
        elif alike(smaller):
            program, changed = smaller, True
        else:
            place += 1
    return program


def _iter_smaller_programs(program: str) -> Iterator[str]:
    """The program with one statement less, or with what is inside of one in its place; the outermost first."""
    for place in itertools.count():
        tree = parse_source(program)
        found = next(itertools.islice(_iter_removable_statements(tree), place, None), None)
        if found is None:
            return
        block, index, may_be_empty = found
        inside = [getattr(block[index], name, []) for name in ("body", "orelse")]
        of_names = isinstance(block[index], ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        whole = list(block)
        for put in ([], *([] if of_names else filter(None, inside))):
            block[:] = [*whole[:index], *put, *whole[index + 1 :]]
            block[:] = block or ([] if may_be_empty else [ast.Pass()])
            text = ast.unparse(ast.fix_missing_locations(tree)) + "\n"
            if text != program:
                yield text


def _iter_removable_statements(tree: ast.Module) -> Iterator[tuple[list[ast.stmt], int, bool]]:
    """Each statement as a place in a block, and whether that block may be empty."""
    for node in ast.walk(tree):
        for name in ("body", "orelse"):
            block = getattr(node, name, None)
            if isinstance(block, list):
                yield from ((block, index, name == "orelse" or node is tree) for index in range(len(block)))


def write_misconception(found: UnexplainedGroup, exercise: Exercise, program: str) -> list[Path]:
    """Adds a misconception to the exercise's grader, for its author to word. Raises CannotWrite."""
    if not isinstance(exercise.grader, CodeGrader):
        raise MisconceptionWriteError(f"« {exercise.id} » n’est pas un exercice de code")
    title = found.description.title if found.description else f"erreur {found.group_id}"
    identity = make_misconception_id(title, exercise.grader.mistake_ids() | SLIPS.keys())
    words = found.description or GroupDescription(
        f"{PLACEHOLDER} : l’erreur en quelques mots", f"{PLACEHOLDER} : pourquoi", f"{PLACEHOLDER} ?"
    )
    functions = [function.name for function in exercise.functions if function.name in found.functions]
    folder = exercise.grader.folder
    file, catalogue = folder / "misconceptions" / f"{identity}.py", folder / MISCONCEPTIONS
    table = format_catalogue_entry(
        exercise.id, identity, functions or [function.name for function in exercise.functions], words
    )
    table = table.partition("\n")[2]
    try:
        file.parent.mkdir(exist_ok=True)
        file.write_text(add_unread_guard(program), encoding="utf-8")
        with catalogue.open("a", encoding="utf-8") as written:
            written.write(f"\n# {describe_frequency(found)}\n{table}")
    except OSError as error:
        raise MisconceptionWriteError(f"impossible d’écrire dans « {folder} » : {error.strerror}") from error
    return [catalogue, file]


def describe_frequency(found: UnexplainedGroup) -> str:
    """Return the number of attempts and students, in French."""
    return f"{found.attempts} essai{'s' * (found.attempts > 1)}, {found.students} élève{'s' * (found.students > 1)}"


def describe_counterexample(found: UnexplainedGroup) -> Sequence[str]:
    """Return the lines of the counterexample."""
    if not found.example:
        return ()
    given = ", ".join(f"{name} = {render.text(value)}" for name, value in found.example["inputs"].items())
    expected, got = value_text_pair(found.example["expected"], found.example["got"])
    return [f"{found.example['function']}({given})", f"attendu : {expected}", f"obtenu  : {got}"]
