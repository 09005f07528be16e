"""From a group of programs that answer alike to what its page shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.code.grading import CodeGrader
from graders.core.contract.verdict import Verdict
from server.behaviour import service as behaviour
from server.behaviour.models import BehaviourName
from server.behaviour.schemas import ClassGroup, GroupMember
from server.classes import repository as classes
from server.course import Course, Exercise
from server.desk import views
from server.desk.groups.schemas import ExampleView, GroupNameForm, GroupPage, NameSuggestion, ProgramRow
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.submissions.models import Submission
from server.web import values
from server.web.views import exercise_href
from server.web.words import format_mark, iso_moment, short_moment

UNKNOWN_STUDENT = "élève"


def group_href(class_id: UUID, exercise: str, group: str) -> str:
    """The address of a group's page."""
    return f"/classes/{class_id}/groupes/{exercise}/{group}"


def build_group_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    account: Account,
    found: ClassGroup,
    earlier: Sequence[BehaviourName],
    wanted: UUID | None,
) -> GroupPage:
    """`wanted` is the attempt to read, None for the shortest program. Raises NotFound."""
    school_class, group = access.school_class, found.group
    exercise = course.exercises.get(group.exercise)
    read = behaviour.load_program(db, school_class, group.id, wanted)
    names = {member.id: member.name for member in classes.load_members(db, school_class.id)}
    href = group_href(school_class.id, group.exercise, group.id)
    may_name = access.has(Right.name_behaviours) and school_class.archived_at is None
    return GroupPage(
        head=views.class_head(course, access, "/groupes"),
        href=href,
        exercise=exercise.title if exercise else group.exercise,
        exercise_href=exercise_href(exercise) if exercise else "",
        outdated=exercise is None or exercise.version != group.exercise_version,
        functions=tuple(group.functions),
        students=found.students,
        total=found.total,
        known=found.known,
        still=len({line.student for line in found.lines if line.latest}),
        example=_example_view(group.example, exercise) if group.example else None,
        code=read.code,
        code_href=f"/soumissions/{read.id}",
        named=found.name is not None,
        may_name=may_name,
        earlier=tuple(
            NameSuggestion(f"{href}?depuis={other.group_id}#nommer", other.title) for other in earlier if may_name
        ),
        questions=_failed_check_hints(db, account, read) if may_name else (),
        titles=_misconception_titles(exercise) if may_name else (),
        rows=tuple(_program_row(line, names, href, read) for line in found.lines),
    )


def group_name_form(name: BehaviourName | None) -> GroupNameForm:
    return GroupNameForm("", "", "") if name is None else GroupNameForm(name.title, name.explanation, name.question)


def name_texts(form: GroupNameForm) -> Mapping[str, str]:
    """Return the fields of the form by their labels, to compare two versions."""
    texts = {"Ce qui est faux": form.title, "Pourquoi": form.explanation, "Question": form.question}
    return {label: text.replace("\r\n", "\n").strip() for label, text in texts.items()}


def _example_view(example: Mapping[str, Any], exercise: Exercise | None) -> ExampleView:
    expected, got, inputs = example["expected"], example["got"], example["inputs"]
    parts = (
        next((function.parts for function in exercise.functions if function.name == example["function"]), ())
        if exercise
        else ()
    )
    return ExampleView(
        function=example["function"],
        inputs=tuple((name, values.value_view(value)) for name, value in inputs.items()),
        expected=None if expected is None else values.name_parts(values.value_view(expected), parts),
        got=values.name_parts(values.value_view(got, expected=expected), parts),
        code=values.inputs_as_code(inputs),
    )


def _failed_check_hints(db: Session, account: Account, read: Submission) -> tuple[str, ...]:
    grading = gradebook.find_attempt(db, account, read.id).grading
    checks = Verdict.from_json(grading.verdict).checks if grading else ()
    return tuple(dict.fromkeys(check.hint for check in checks if not check.passed and check.hint))


def _misconception_titles(exercise: Exercise | None) -> tuple[str, ...]:
    if exercise is None or not isinstance(exercise.grader, CodeGrader):
        return ()
    return tuple(dict.fromkeys(misconception.title for misconception in exercise.grader.misconceptions))


def _program_row(line: GroupMember, names: Mapping[UUID, str], href: str, read: Submission) -> ProgramRow:
    return ProgramRow(
        name=names.get(line.student, UNKNOWN_STUDENT),
        href=f"/soumissions/{line.submission}",
        read_href=f"{href}?essai={line.submission}#programme",
        sent=iso_moment(line.sent_at),
        sent_text=short_moment(line.sent_at),
        points="" if line.score is None else format_mark(20 * line.score),
        latest=line.latest,
        shown=line.submission == read.id,
    )


def author_name_words(db: Session, access: ClassAccess, account_id: UUID) -> Sequence[str]:
    """Every word of the author's names, as the account and the class's list have them."""
    found = next(iter(classes.load_members(db, access.school_class.id, [account_id])), None)
    if found is None:
        return ()
    given = (found.name, found.account.name, found.membership.family_name, found.membership.given_name)
    return [word for text in (*given, found.account.login or "") for word in text.split()]
