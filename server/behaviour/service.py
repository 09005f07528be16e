"""Groups of behaviour as a class knows them, and their names. Functions work inside the caller's transaction."""

import re
import unicodedata
from collections.abc import Collection, Sequence
from dataclasses import replace
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.bounds import bounded
from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import TEACHER, Diagnosis, Verdict
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Invalid, NotFound
from server.behaviour import repository
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

UNKNOWN = "Ce groupe d’essais n’existe pas dans cette classe."
MOST_LINES = 200
LINE_END = re.compile("\r\n|\r|\n")
EMPTY = "{what} ne peut pas être vide."
TOO_LONG = "{what} est trop long : {length} caractères, {most} au plus."


def load_verdict(db: Session, attempt: Attempt) -> Verdict | None:
    """The verdict that counts, as it is kept; where no misconception is named, with what the teacher says of its group.

    What is kept never changes: the name is joined as it is read. What is held back from who looks is left out.
    """
    if attempt.grading is None:
        return None
    verdict = attempt.verdict
    if verdict is None or attempt.feedback.diagnosis is not None:
        return verdict
    if verdict.diagnosis is not None or verdict.outcome not in repository.OBSERVED:
        return verdict
    name = repository.name_for(db, attempt.submission.account_id, attempt.grading.id)
    if name is None:
        return verdict
    return bounded(Judgement(replace(verdict, diagnosis=_diagnosis(*name)))).verdict


def _diagnosis(group_id: str, title: str, explanation: str, question: str) -> Diagnosis:
    return Diagnosis(group_id, title, "\n\n".join(part for part in (explanation, question) if part), TEACHER)


def list_unnamed_groups(
    db: Session, class_id: UUID, students: Collection[UUID], exercises: Collection[str]
) -> Sequence[UnnamedGroup]:
    """The groups of the latest attempts that failed without a misconception: most students first, then the newest.

    In one query, whatever the class. A group that has a name from its teacher says it.
    """
    found: dict[tuple[str, str], list[tuple[UUID, UUID, str | None]]] = {}
    for exercise, group, student, submission, title in repository.unnamed(db, class_id, students, exercises):
        found.setdefault((exercise, group), []).append((student, submission, title))
    groups = [
        UnnamedGroup(exercise, group, tuple(dict.fromkeys(row[0] for row in rows)), rows[0][1], rows[0][2])
        for (exercise, group), rows in found.items()
    ]
    return sorted(groups, key=lambda one: -len(one.students))


def find_group(db: Session, school_class: SchoolClass, exercise: str, group_id: str) -> BehaviourGroup:
    """A group that some student of the class is in, of an exercise of its module. Raises NotFound."""
    group = repository.group(db, group_id) if group_id.isalnum() else None  # no database looks for a zero byte
    known = group is not None and group.exercise == exercise and exercise.startswith(f"{school_class.module}/")
    if group is None or not known or not repository.has_members(db, school_class.id, group_id):
        raise NotFound(UNKNOWN)
    return group


def load_class_group(db: Session, school_class: SchoolClass, exercise: str, group_id: str) -> ClassGroup:
    """The group with its name and its attempts in this class. Raises NotFound."""
    group = find_group(db, school_class, exercise, group_id)
    lines = tuple(repository.members(db, school_class.id, group_id, MOST_LINES))
    total, students, known = repository.counts(db, school_class.id, group_id)
    return ClassGroup(group, repository.name(db, school_class.id, group_id), lines, total, students, known)


def count_students(db: Session, school_class: SchoolClass, group: BehaviourGroup) -> int:
    """How many of the class have sent such a program."""
    return repository.counts(db, school_class.id, group.id)[1]


def load_program(
    db: Session, school_class: SchoolClass, group_id: str, submission_id: UUID | None = None
) -> Submission:
    """A program of the class in this group: the one that is wanted, or else the shortest. Raises NotFound."""
    if submission_id is None:
        submission = repository.smallest(db, school_class.id, group_id)
    else:
        submission = repository.attempt(db, school_class.id, group_id, submission_id)
    if submission is None:
        raise NotFound(UNKNOWN)
    return submission


def list_other_names(db: Session, school_class: SchoolClass, exercise: str, besides: str) -> Sequence[BehaviourName]:
    """What the class calls other groups of an exercise: the same words may fit, as after a change of its version.

    Of equal words one is enough.
    """
    found = {
        description_of(one): one for one in repository.names(db, school_class.id, exercise) if one.group_id != besides
    }
    return list(found.values())


def parse_description(title: str, explanation: str, question: str) -> GroupDescription:
    """What a teacher writes, within bounds. Raises Invalid, with the place. A question is not required."""
    given = GroupDescription(" ".join(_lines(title).split("\n")), _lines(explanation), _lines(question))
    bounds = (
        ("title", "Le titre", given.title, TITLE_LENGTH),
        ("explanation", "Le texte de l’explication", given.explanation, EXPLANATION_LENGTH),
        ("question", "Le texte de la question", given.question, QUESTION_LENGTH),
    )
    for place, what, text, most in bounds:
        if not text and place != "question":
            raise Invalid(EMPTY.format(what=what))
        if len(text) > most:
            raise Invalid(TOO_LONG.format(what=what, length=len(text), most=most))
    return given


def _lines(text: str) -> str:
    """Without what is no text: blank lines part paragraphs, whatever the browser's ends of lines."""
    lines = ("".join(one for one in line if _is_text(one)).rstrip() for line in LINE_END.split(text))
    return "\n".join(lines).strip()


def _is_text(character: str) -> bool:
    return unicodedata.category(character) not in {"Cc", "Cf", "Cs"} or character in "\t\u200d"


def set_group_name(
    db: Session, school_class: SchoolClass, group: BehaviourGroup, given: GroupDescription, by: UUID
) -> BehaviourName:
    """All of the class in the group are told so from now on."""
    name = repository.name(db, school_class.id, group.id)
    before = None if name is None else _values(name)
    if name is None:
        name = BehaviourName(class_id=school_class.id, group_id=group.id)
        db.add(name)
    name.title, name.explanation, name.question = given.title, given.explanation, given.question
    name.named_by, name.named_at = by, utc_now()
    after = _values(name)
    if before != after:
        audit.record_event(
            db, school_class.id, by, AuditAction.name_given, about=_about(group), before=before, after=after
        )
    return name


def withdraw_group_name(db: Session, school_class: SchoolClass, group: BehaviourGroup, by: UUID) -> bool:
    """Nobody is told so any more; False where there was no name."""
    name = repository.name(db, school_class.id, group.id)
    if name is None:
        return False
    audit.record_event(db, school_class.id, by, AuditAction.name_withdrawn, about=_about(group), before=_values(name))
    db.delete(name)
    return True


def description_of(name: BehaviourName) -> GroupDescription:
    return GroupDescription(name.title, name.explanation, name.question)


def _about(group: BehaviourGroup) -> str:
    return f"{group.exercise}, groupe {group.id}"


def _values(name: BehaviourName) -> dict[str, str]:
    return {"title": name.title, "explanation": name.explanation, "question": name.question}
