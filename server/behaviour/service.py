"""Groups of behaviour within a class, and their names. Functions work inside the caller's transaction."""

import re
import unicodedata
from collections.abc import Collection, Sequence
from dataclasses import replace
from datetime import timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.code.places import add_place_to_diagnosis, is_worth_searching
from graders.core.contract.bounds import limit_size
from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import TEACHER, Diagnosis, Verdict
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Invalid, NotFound
from server.behaviour import place_queries, repository
from server.behaviour.models import (
    EXPLANATION_LENGTH,
    QUESTION_LENGTH,
    TITLE_LENGTH,
    BehaviourGroup,
    BehaviourName,
)
from server.behaviour.schemas import ClassGroup, GroupDescription, UnnamedGroup
from server.classes.models import SchoolClass
from server.database import utc_now
from server.gradebook.schemas import Attempt
from server.submissions.models import Submission
from server.text.lines import normalise_line

UNKNOWN = "Ce groupe d’essais n’existe pas dans cette classe."
MAX_LINES = 200
#: How long a page looks for the places of mistakes after a verdict.
SEARCH_PATIENCE = timedelta(minutes=2)
LINE_END = re.compile("\r\n|\r|\n")
EMPTY = "{what} ne peut pas être vide."
TOO_LONG = "{what} est trop long : {length} caractères, {most} au plus."


def load_visible_verdict(db: Session, attempt: Attempt) -> Verdict | None:
    """Return the counting verdict as the account may see it, with the places of its mistakes that were found since.

    Without a known misconception, its diagnosis is the teacher's name for its group. The stored verdict never changes:
    names and places are joined when it is read.
    """
    return load_visible_verdict_and_search_state(db, attempt)[0]


def load_visible_verdict_and_search_state(db: Session, attempt: Attempt) -> tuple[Verdict | None, bool]:
    """Return `load_visible_verdict`, and whether the places of the program's mistakes may still be found, soon after
    it."""
    grading, verdict = attempt.grading, attempt.verdict
    if grading is None or verdict is None or attempt.feedback.diagnosis is not None:
        return verdict, False
    if verdict.outcome not in repository.OBSERVABLE_OUTCOMES:
        return verdict, False
    diagnosis = verdict.diagnosis
    if diagnosis is None:
        name = repository.load_latest_teacher_name(db, attempt.submission.account_id, grading.id)
        diagnosis = None if name is None else _teacher_diagnosis(*name)
    is_observed, place = place_queries.load_mistake_places(db, grading.id)
    if place is not None:
        diagnosis = add_place_to_diagnosis(diagnosis, Diagnosis.from_json(place))
    is_recent = utc_now() - grading.finished_at < SEARCH_PATIENCE
    is_search_pending = is_recent and not is_observed and is_worth_searching(verdict)
    if diagnosis is not verdict.diagnosis:
        verdict = limit_size(Judgement(replace(verdict, diagnosis=diagnosis))).verdict
    return verdict, is_search_pending


def _teacher_diagnosis(group_id: str, title: str, explanation: str, question: str) -> Diagnosis:
    return Diagnosis(group_id, title, "\n\n".join(part for part in (explanation, question) if part), TEACHER)


def list_unnamed_groups(
    db: Session, class_id: UUID, students: Collection[UUID], exercises: Collection[str]
) -> Sequence[UnnamedGroup]:
    """Return the groups of the latest attempts that failed without a known misconception, in one query.

    Most students first, then the newest.
    """
    rows_by_group: dict[tuple[str, str], list[tuple[UUID, UUID, str | None]]] = {}
    for exercise, group, student, submission, title in repository.list_latest_unnamed(
        db, class_id, students, exercises
    ):
        rows_by_group.setdefault((exercise, group), []).append((student, submission, title))
    groups = [
        UnnamedGroup(exercise, group, tuple(dict.fromkeys(row[0] for row in rows)), rows[0][1], rows[0][2])
        for (exercise, group), rows in rows_by_group.items()
    ]
    return sorted(groups, key=lambda group: -len(group.students))


def find_group(db: Session, school_class: SchoolClass, exercise: str, group_id: str) -> BehaviourGroup:
    """Return a group with a student of the class, of an exercise of its module. Raise NotFound."""
    group = repository.find_group(db, group_id) if group_id.isalnum() else None  # no database looks for a zero byte
    known = group is not None and group.exercise == exercise and exercise.startswith(f"{school_class.module}/")
    if group is None or not known or not repository.has_member_attempts(db, school_class.id, group_id):
        raise NotFound(UNKNOWN)
    return group


def load_class_group(db: Session, school_class: SchoolClass, exercise: str, group_id: str) -> ClassGroup:
    """Return the group with its name and its attempts in this class. Raise NotFound."""
    group = find_group(db, school_class, exercise, group_id)
    lines = tuple(repository.list_member_attempts(db, school_class.id, group_id, MAX_LINES))
    total, students, known = repository.count_member_attempts(db, school_class.id, group_id)
    return ClassGroup(
        group, repository.find_behaviour_name(db, school_class.id, group_id), lines, total, students, known
    )


def count_students_in_group(db: Session, school_class: SchoolClass, group: BehaviourGroup) -> int:
    """Count the students of the class with a program in the group."""
    return repository.count_member_attempts(db, school_class.id, group.id)[1]


def load_group_program(
    db: Session, school_class: SchoolClass, group_id: str, submission_id: UUID | None = None
) -> Submission:
    """Return a program of the class in this group: a given one, else the shortest. Raise NotFound."""
    if submission_id is None:
        submission = repository.find_shortest_program(db, school_class.id, group_id)
    else:
        submission = repository.find_member_attempt(db, school_class.id, group_id, submission_id)
    if submission is None:
        raise NotFound(UNKNOWN)
    return submission


def list_other_names(
    db: Session, school_class: SchoolClass, exercise: str, excluded_group: str
) -> Sequence[BehaviourName]:
    """Return the class's names of other groups of an exercise, which may fit again after a change of its version.

    Equal descriptions are returned once.
    """
    names = repository.list_behaviour_names(db, school_class.id, exercise)
    by_description = {build_group_description(name): name for name in names if name.group_id != excluded_group}
    return list(by_description.values())


def parse_group_description(title: str, explanation: str, question: str) -> GroupDescription:
    """Return a cleaned description within bounds; the question is optional. Raise Invalid."""
    description = GroupDescription(
        normalise_line(_normalise_lines(title)), _normalise_lines(explanation), _normalise_lines(question)
    )
    bounds = (
        ("title", "Le titre", description.title, TITLE_LENGTH),
        ("explanation", "Le texte de l’explication", description.explanation, EXPLANATION_LENGTH),
        ("question", "Le texte de la question", description.question, QUESTION_LENGTH),
    )
    for field, label, text, limit in bounds:
        if not text and field != "question":
            raise Invalid(EMPTY.format(what=label))
        if len(text) > limit:
            raise Invalid(TOO_LONG.format(what=label, length=len(text), most=limit))
    return description


def _normalise_lines(text: str) -> str:
    """Normalise line ends, and drop control characters and trailing blanks."""
    lines = (
        "".join(character for character in line if _is_printable_or_tab(character)).rstrip()
        for line in LINE_END.split(text)
    )
    return "\n".join(lines).strip()


def _is_printable_or_tab(character: str) -> bool:
    return unicodedata.category(character) not in {"Cc", "Cf", "Cs"} or character in "\t\u200d"


def set_group_name(
    db: Session, school_class: SchoolClass, group: BehaviourGroup, description: GroupDescription, by: UUID
) -> BehaviourName:
    """Show this description to all of the class in the group from now on."""
    name = repository.find_behaviour_name(db, school_class.id, group.id)
    before = None if name is None else _audit_values(name)
    if name is None:
        name = BehaviourName(class_id=school_class.id, group_id=group.id)
        db.add(name)
    name.title, name.explanation, name.question = description.title, description.explanation, description.question
    name.named_by, name.named_at = by, utc_now()
    after = _audit_values(name)
    if before != after:
        audit.record_event(
            db, school_class.id, by, AuditAction.name_given, about=_audit_subject(group), before=before, after=after
        )
    return name


def withdraw_group_name(db: Session, school_class: SchoolClass, group: BehaviourGroup, by: UUID) -> bool:
    """Withdraw the name of a group in a class. Return False where there was none."""
    name = repository.find_behaviour_name(db, school_class.id, group.id)
    if name is None:
        return False
    audit.record_event(
        db, school_class.id, by, AuditAction.name_withdrawn, about=_audit_subject(group), before=_audit_values(name)
    )
    db.delete(name)
    return True


def build_group_description(name: BehaviourName) -> GroupDescription:
    return GroupDescription(name.title, name.explanation, name.question)


def _audit_subject(group: BehaviourGroup) -> str:
    return f"{group.exercise}, groupe {group.id}"


def _audit_values(name: BehaviourName) -> dict[str, str]:
    return {"title": name.title, "explanation": name.explanation, "question": name.question}
