"""From exemptions and rules to what the templates show: their list, its export, why a date is what it is."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, sitting_repository
from server.assignments.exemption_service import (
    NO_STUDENT,
    ExplainedValue,
    changed_fields,
    explain_rules,
    filter_active_students,
    list_student_labels,
)
from server.assignments.models import Assignment, EndedBy, Exemption, Mode, Sitting
from server.assignments.rules import Rules, is_sitting_running, sitting_end
from server.assignments.student_assignments import load_student_assignment
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import team_rules_in_force
from server.base import school_time
from server.base.errors import NotFound
from server.classes import repository as classes
from server.classes.schemas import Member
from server.course import Course
from server.database import utc_now
from server.desk import views
from server.desk.assignments import words
from server.desk.assignments.exemption_schemas import (
    ExemptionRow,
    ExemptionsPage,
    ExemptionValues,
    ExplainedField,
    ExplanationStep,
    RulesExplanationPage,
)
from server.desk.assignments.late_line import draw_late_line
from server.desk.assignments.views import TAB, assignment_href, format_date, may_manage
from server.marks.cells import write_french_csv
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.text.plain import show_invisible_characters
from server.web.form_version import form_version_tag
from server.web.time_warnings import compute_time_warnings
from server.web.words import format_short_time

ORDERS = ("eleve", "date")
NOBODY = "La classe n’a pas encore d’élève."
LEFT_CLASS = "n’est plus dans la classe"


def build_exemptions_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    assignment: Assignment,
    order: str,
    values: ExemptionValues | None = None,
    problems: Mapping[str, str] | None = None,
    version: str = "",
) -> ExemptionsPage:
    """A bounded number of queries, however many there are."""
    members = classes.load_members(db, access.school_class.id)
    order = order if order in ORDERS else ORDERS[0]
    names = words.field_names(is_test=assignment.mode == Mode.test)
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    return ExemptionsPage(
        head=views.class_head(course, access, TAB),
        title=assignment.title,
        href=assignment_href(assignment),
        version=version or exemptions_version(db, assignment),
        rows=tuple(_sorted_rows(assignment, exemptions, members, order)),
        order=order,
        students=tuple((str(each.id), each.name) for each in filter_active_students(members)),
        groups=tuple(list_student_labels(members)),
        values=values or ExemptionValues(),
        problems=problems or {},
        may_keep=may_manage(access),
        zone=school_time.time_zone_name(),
        own=tuple(
            (names[name], words.format_field_value(name, getattr(assignment, name)))
            for name in ("opens_at", "due_at", "closes_at")
        ),
        warnings=compute_time_warnings(db, assignment, exemptions, members),
    )


def exemptions_version(db: Session, assignment: Assignment) -> str:
    """Return the version tag of the exemptions in force."""
    active = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    return form_version_tag({str(exemption.id): "" for exemption in active})


def _sorted_rows(
    assignment: Assignment, exemptions: Collection[Exemption], members: Sequence[Member], order: str
) -> Sequence[ExemptionRow]:
    """Those that hold first, then those revoked; by the class's list, groups before, or the newest first."""
    places = {each.id: (access, each) for access, each in enumerate(members)}

    def key(each: Exemption) -> tuple[object, ...]:
        seat = places.get(each.account_id) if each.account_id else None
        held = each.revoked_at is not None
        if order == "date":
            return held, -each.created_at.timestamp()
        return held, seat is not None, seat[0] if seat else 0, (each.label or "").casefold(), each.created_at

    return [_exemption_row(assignment, each, places) for each in sorted(exemptions, key=key)]


def _exemption_row(assignment: Assignment, each: Exemption, places: Mapping[UUID, tuple[int, Member]]) -> ExemptionRow:
    seat = places.get(each.account_id) if each.account_id else None
    member = seat[1] if seat else None
    author = places.get(each.created_by) if each.created_by else None
    why = f"{assignment_href(assignment)}/pourquoi?eleve={each.account_id}" if member and not each.label else ""
    return ExemptionRow(
        id=str(each.id),
        who=each.label or (member.name if member else LEFT_CLASS),
        is_group=each.label is not None,
        why_href=why,
        effects=tuple(_described_effects(assignment, each)),
        reason=each.reason,
        by=author[1].name if author else "",
        made=replace(format_date(each.created_at), text=format_short_time(each.created_at)),
        revoked=format_date(each.revoked_at),
    )


def _described_effects(assignment: Assignment, each: Exemption) -> Iterator[tuple[str, str]]:
    names = words.field_names(is_test=assignment.mode == Mode.test)
    for name, said in changed_fields(each).items():
        yield names[name], words.format_field_value(name, said)  # type: ignore[index]


def exemptions_csv(db: Session, access: ClassAccess, assignment: Assignment, order: str) -> bytes:
    """For a French spreadsheet."""
    names = list(words.field_names(is_test=assignment.mode == Mode.test).values())
    header = ["Pour", "Groupe", *names, "Raison", "Accordé par", "Accordé le", "Retiré le"]
    rows = []
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    for row in _sorted_rows(assignment, exemptions, classes.load_members(db, access.school_class.id), order):
        told = dict(row.effects)
        who = ["", row.who] if row.is_group else [row.who, ""]
        effects_of = [told.get(name, "") for name in names]
        rows.append([*who, *effects_of, row.reason, row.by, row.made.text, row.revoked.text])
    return b"".join(write_french_csv(header, rows))


def build_rules_explanation_page(
    db: Session, course: Course, access: ClassAccess, assignment: Assignment, student: Member
) -> RulesExplanationPage:
    """For the staff with the reasons; for the student themself without."""
    staff = access.has(Right.see_students)
    exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
    seat = student.membership
    places = load_places_of_team_assignments(db, [assignment]).get(assignment.id, ())
    rules = team_rules_in_force(assignment, exemptions, seat.account_id, seat.groups, places)
    if not staff:
        load_student_assignment(db, assignment, seat.account_id, seat.groups, utc_now())
    told = explain_rules(rules, exemptions, seat.account_id)
    names = words.field_names(is_test=rules.is_test)
    asked = [name for name in names if name != "time_factor" or assignment.duration_minutes or len(told[name]) > 1]
    members = classes.load_members(db, access.school_class.id) if staff else ()
    return RulesExplanationPage(
        head=views.class_head(course, access, TAB),
        title=assignment.title,
        href=assignment_href(assignment)
        if staff
        else f"{views.class_href(access.school_class)}#devoir-{assignment.id}",
        student=str(student.id),
        name=student.name,
        fields=tuple(
            ExplainedField(
                names[name],
                words.format_field_value(name, told[name][0].value),
                _explanation_steps(name, told[name], staff=staff),
            )
            for name in asked
        ),
        late=words.describe_late_rules(rules) if rules.due_at else "",
        line=draw_late_line(rules),
        people=tuple((str(each.id), each.name) for each in filter_active_students(members)),
        for_staff=staff,
        is_concerned=rules.is_concerned,
        sitting=_sitting_sentence(sitting_repository.load_sitting(db, assignment.id, seat.account_id), rules)
        if assignment.mode == Mode.test
        else "",
    )


def _sitting_sentence(found: Sitting | None, rules: Rules) -> str:
    """A sentence on a test: what the rules come to for who has begun it."""
    if found is None:
        return "Pas encore commencé."
    began, end = f"Commencé le {format_short_time(found.began_at)}", sitting_end(rules, found)
    if is_sitting_running(rules, found, utc_now()):
        return f"{began} ; fin le {format_short_time(end)}." if end else f"{began} ; sans heure de fin."
    ended = "rendu" if found.ended_by == EndedBy.student else "temps écoulé"
    return f"{began} ; {ended} le {format_short_time(end)}." if end else f"{began}."


ORIGIN_WORDS = {
    "assignment": "Le devoir, pour tous",
    "adjusted": "reportée automatiquement",
    "student": "Un aménagement pour l’élève",
    "team": "La date la plus tardive de ceux qui rendent ensemble",
}
ADJUSTED = "la fermeture ne vient ni avant la date de remise, ni avant la fin du temps en plus"


def _explanation_steps(name: str, told: Sequence[ExplainedValue], *, staff: bool) -> tuple[ExplanationStep, ...]:
    """From what is said to all to what holds."""
    steps = [
        ExplanationStep(
            who=_origin_words(each, staff=staff),
            value=words.format_field_value(name, each.value),
            reason=ADJUSTED if each.origin == "adjusted" else each.reason if staff else "",
            holds=each is told[0],
        )
        for each in reversed(told)
    ]
    return tuple(steps)


def _origin_words(told: ExplainedValue, *, staff: bool) -> str:
    if told.origin == "label":
        return f"Un aménagement pour le groupe « {show_invisible_characters(told.label)} »"
    return ORIGIN_WORDS[told.origin] if staff or told.origin != "student" else "Un aménagement pour vous"


def find_student(db: Session, access: ClassAccess, name: str) -> Member:
    """A student who is in the class now; the first, where none is named. Raises NotFound."""
    for each in filter_active_students(classes.load_members(db, access.school_class.id)):
        if not name or str(each.id) == name.lower():
            return each
    raise NotFound(NO_STUDENT if name else NOBODY)
