"""The page of a group of programs that answer alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.code.grading import CodeGrader
from graders.core.contract.verdict import Verdict
from graders.core.declared.grading import DeclaredGrader
from server.behaviour import service as behaviour
from server.behaviour.models import BehaviourName
from server.behaviour.schemas import ClassGroup
from server.classes import repository as classes
from server.course import Course, Exercise
from server.desk import views
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.submissions.models import Submission
from server.web import values


@dataclass(frozen=True)
class GroupNameForm:
    """The values of the form, and why they are refused."""

    title: str = ""
    explanation: str = ""
    question: str = ""
    problem: str = ""


def group_href(class_id: UUID, exercise: str, group: str) -> str:
    return f"/classes/{class_id}/groupes/{exercise}/{group}"


def build_group_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    account: Account,
    listed: ClassGroup,
    earlier: Sequence[BehaviourName],
    wanted: UUID | None,
) -> dict[str, Any]:
    """Build the page; `wanted` is the attempt to read, None for the shortest program. Raise NotFound."""
    school_class, group = access.school_class, listed.group
    exercise = course.exercises.get(group.exercise)
    program = behaviour.load_group_program(db, school_class, group.id, wanted)
    may_name = access.has(Right.name_behaviours) and school_class.archived_at is None
    return {
        "head": views.class_head(course, access, "/groupes"),
        "href": group_href(school_class.id, group.exercise, group.id),
        "listed": listed,
        "exercise": exercise,
        "outdated": exercise is None or exercise.version != group.exercise_version,
        "still": len({member.student for member in listed.lines if member.latest}),
        "example": _example_view(group.example, exercise) if group.example else None,
        "program": program,
        "may_name": may_name,
        "earlier": earlier if may_name else (),
        "questions": _failed_check_hints(db, account, program) if may_name else (),
        "titles": _misconception_titles(exercise) if may_name else (),
        "names": {member.id: member.name for member in classes.load_members(db, school_class.id)},
    }


def name_texts(name: GroupNameForm | BehaviourName) -> Mapping[str, str]:
    """Return the texts of a name by their labels, to compare two versions."""
    texts = {"Ce qui est faux": name.title, "Pourquoi": name.explanation, "Question": name.question}
    return {label: text.replace("\r\n", "\n").strip() for label, text in texts.items()}


def _example_view(example: Mapping[str, Any], exercise: Exercise | None) -> dict[str, Any]:
    """Lay out what the programs answer to an input; `expected` is None where several answers are right."""
    expected, inputs, functions = example["expected"], example["inputs"], exercise.functions if exercise else ()
    parts = next((function.parts for function in functions if function.name == example["function"]), ())
    expected_view, got_view = values.build_value_view_pair(expected, example["got"])
    return {
        "function": example["function"],
        "inputs": [(name, values.build_value_view(value)) for name, value in inputs.items()],
        "expected": None if expected is None else values.name_items_of_list(expected_view, parts),
        "got": values.name_items_of_list(got_view, parts),
        "code": values.write_inputs_as_code(inputs),
    }


def _failed_check_hints(db: Session, account: Account, read: Submission) -> tuple[str, ...]:
    grading = gradebook.find_attempt(db, account, read.id).grading
    checks = Verdict.from_json(grading.verdict).checks if grading else ()
    return tuple(dict.fromkeys(check.hint for check in checks if not check.passed and check.hint))


def _misconception_titles(exercise: Exercise | None) -> tuple[str, ...]:
    if exercise is not None and isinstance(exercise.grader, DeclaredGrader):
        return tuple(mistake.title for mistake in exercise.grader.declaration.mistakes)
    if exercise is None or not isinstance(exercise.grader, CodeGrader):
        return ()
    return tuple(dict.fromkeys(misconception.title for misconception in exercise.grader.misconceptions))


def author_name_words(db: Session, access: ClassAccess, account_id: UUID) -> Sequence[str]:
    """Every word of the author's names, as the account and the class's list have them."""
    found = next(iter(classes.load_members(db, access.school_class.id, [account_id])), None)
    if found is None:
        return ()
    given = (found.name, found.account.name, found.membership.family_name, found.membership.given_name)
    return [word for text in (*given, found.account.login or "") for word in text.split()]
