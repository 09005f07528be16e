"""The dates of a person's classes as a calendar, and its secret address. Functions work in the caller's transaction.

A student's calendar has the dates in force for them, without assignments from which they are exempt; that of staff has
the dates of the assignments, and no student's name.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime, timedelta
from hmac import compare_digest
from itertools import islice

from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.assignments.models import Assignment, LatePolicy, Mode
from server.assignments.rules import Rules, rules_in_force
from server.assignments.student_assignments import load_assignments_for_student
from server.base.errors import Forbidden, NotFound
from server.calendars import repository
from server.calendars.icalendar import CalendarEvent, write_calendar
from server.classes import repository as classes
from server.classes.schemas import JoinedClass
from server.database import utc_now
from server.identity import secrets
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right

UNKNOWN = "Cette adresse d’agenda n’existe pas, ou a été remplacée : la page « Mon compte » en donne une nouvelle."
FOR_ACCOUNTS = "Créez d’abord un compte : il garde vos dates, et votre adresse d’agenda."
NAME = "Balise"
#: A calendar has the dates of the last year and all later ones.
PAST = timedelta(days=366)
MAX_EVENTS = 2000
#: The longest test that is one event; a longer one has its opening and its end as moments.
MAX_TEST_EVENT = timedelta(hours=12)


def renew_calendar_address(db: Session, account: Account) -> str:
    """Return the token of a new address, which is never stored; the earlier one stops working.

    Raises Forbidden for a guest, whose account ends with the browser's session.
    """
    if account.is_guest:
        raise Forbidden(FOR_ACCOUNTS)
    token = secrets.draw_secret_token()
    repository.save_calendar_address(db, account.id, secrets.sha256_hex(token))
    return token


def delete_calendar_address(db: Session, account: Account) -> None:
    """Make the calendar's address stop working."""
    repository.delete_calendar_address(db, account.id)


def find_calendar_owner(db: Session, token: str) -> Account:
    """Return the account whose calendar has this address. Raises NotFound."""
    digest = secrets.sha256_hex(token)
    row = repository.find_calendar_owner(db, digest)
    if row is None or not compare_digest(row[0].token_digest, digest):
        raise NotFound(UNKNOWN)
    return row[1]


def build_calendar(db: Session, account: Account, base: str) -> bytes:
    """Return a person's calendar. `base`: the URL of the service, without a trailing slash."""
    now = utc_now()
    events = [
        event
        for joined in classes.load_joined_classes(db, account.id)
        if joined.school_class.archived_at is None
        for event in _class_events(db, account, joined, base, now)
        if event.start >= now - PAST
    ]
    return write_calendar(NAME, list(islice(sorted(events, key=lambda event: (event.start, event.uid)), MAX_EVENTS)))


def _class_events(
    db: Session, account: Account, joined: JoinedClass, base: str, now: datetime
) -> Iterator[CalendarEvent]:
    school_class, membership = joined.school_class, joined.membership
    if not rights.build_class_access(account, school_class, membership).has(Right.see_assignments):
        return  # asks to join
    page = f"{base}/classes/{school_class.id}"
    if membership.is_staff:
        given = assignments.load_class_assignments(db, school_class.id)
        exemptions = assignments.count_exemptions(db, [assignment.id for assignment in given])
        for assignment in given:
            url = f"{page}/devoirs/{assignment.id}"
            count = exemptions.get(assignment.id, 0)
            lines = [f"Pour {', '.join(assignment.groups)}."] if assignment.groups else []
            note = "\n".join([*lines, f"Aménagements accordés : {count}."] if count else lines)
            rules = rules_in_force(assignment, (), account.id, ())
            yield from _assignment_events(assignment, rules, school_class.name, note, url, now)
        return
    for student in load_assignments_for_student(db, school_class.id, account.id, membership.groups, now):
        if not student.rules.excused:
            url = f"{page}#devoir-{student.assignment.id}"
            note = "Un aménagement vous a été accordé." if student.exemptions else ""
            yield from _assignment_events(student.assignment, student.rules, school_class.name, note, url, now)


def _assignment_events(
    assignment: Assignment,
    rules: Rules,
    class_name: str,
    note: str,
    url: str,
    now: datetime,
) -> Iterator[CalendarEvent]:
    title = f"{assignment.title} ({class_name})"
    changes = _date_change_times(assignment, rules)
    is_test = assignment.mode == Mode.test
    duration = "" if rules.duration is None else f"Durée : {_format_minutes(rules.duration)}."
    description = "\n".join(line for line in (duration, note, url) if line)

    def event(kind: str, start: datetime, words: str, end: datetime | None = None) -> CalendarEvent:
        return CalendarEvent(
            uid=f"{assignment.id}-{kind}@balise",
            start=start,
            end=end,
            summary=f"{words} : {title}",
            changed_at=changes[-1],
            sequence=len(changes) - 1,
            description=description,
            url=url,
        )

    last = rules.latest_counting_time
    if is_test and last is not None and rules.opens_at < last <= rules.opens_at + MAX_TEST_EVENT:
        yield event("controle", rules.opens_at, "Contrôle", last)
    else:
        if is_test:
            yield event("ouverture", rules.opens_at, "Ouverture du contrôle")
        if rules.due_at is not None:
            yield event("limite", rules.due_at, "À commencer avant" if is_test else "Date limite")
        if rules.closes_at is not None and _closes_after_due(rules, rules.closes_at):
            yield event("fermeture", rules.closes_at, "Fermeture")
    if is_test and assignment.released_at is not None and assignment.released_at <= now:
        yield event("resultats", assignment.released_at, "Résultats publiés")


def _closes_after_due(rules: Rules, closes_at: datetime) -> bool:
    """Whether the closing is a date of its own: attempts still count after the due date."""
    return rules.due_at is None or (closes_at > rules.due_at and rules.late is not LatePolicy.refuse)


def _date_change_times(assignment: Assignment, rules: Rules) -> Sequence[datetime]:
    """Return when the dates in force were set and changed, in order."""
    released = [] if assignment.released_at is None else [assignment.released_at]
    return sorted([assignment.created_at, *(past.until for past in rules.earlier), *released])


def _format_minutes(duration: timedelta) -> str:
    hours, minutes = divmod(round(duration.total_seconds() / 60), 60)
    return f"{hours} h {minutes:02d}" if hours and minutes else f"{hours} h" if hours else f"{minutes} min"
