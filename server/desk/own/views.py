"""A class as who learns there sees it: what is to be done, until when, what is done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime

from sqlalchemy.orm import Session

from server.assignments import mine
from server.assignments.counting import Result
from server.assignments.mine import Mine
from server.assignments.models import AssignedExercise, Mode
from server.assignments.rules import FULL, Rules
from server.assignments.states import Stage
from server.classes import repository
from server.classes.models import Membership, Seat, Status
from server.classes.schemas import Member
from server.course import Course
from server.database import utc_now
from server.desk import views
from server.desk.assignments import words
from server.desk.assignments.schemas import NextThing, OwnAssignment, OwnExercise, OwnPage
from server.desk.assignments.views import stage_view, when
from server.desk.own import results
from server.desk.own.results import Results
from server.desk.schemas import OwnSeat
from server.identity.models import Account
from server.marks.schemas import Set
from server.rights.models import Right
from server.rights.service import Place
from server.text.plain import visible
from server.web import school_time
from server.web.views import exercise_href
from server.web.words import WHOLE, mark, plural


def own_page(db: Session, course: Course, place: Place, account: Account) -> OwnPage:
    """Of a member who is none of the staff."""
    membership = place.membership
    assert membership is not None  # who has no seat is an administrator, who sees the class as its staff do
    may_see, may_leave = place.may(Right.see_assignments), place.may(Right.leave_class)
    return _page(db, course, place, account, membership, may_see=may_see, may_leave=may_leave)


def watched_page(db: Session, course: Course, place: Place, account: Account, student: Member) -> OwnPage:
    """The page of a student, as their teacher looks at it: the same, with nothing to press."""
    return _page(db, course, place, account, student.membership, watched=student)


def _page(
    db: Session,
    course: Course,
    place: Place,
    account: Account,
    seat: Membership,
    *,
    may_see: bool = True,
    may_leave: bool = False,
    watched: Member | None = None,
) -> OwnPage:
    now = utc_now()
    everyone = repository.members(db, place.school_class.id)
    found = mine.of_class(db, seat.class_id, seat.account_id, seat.groups, now) if may_see else ()
    told = [one for one in found if not one.secret]
    known = results.of_student(db, seat.account_id, told)
    by_hand = results.set_by_hand(db, seat.class_id, seat.account_id, told)
    suffix = "" if watched is None else f"?eleve={seat.account_id}"
    shown = [(one, _assignment(course, one, known, by_hand, suffix)) for one in found]
    own = OwnSeat(views.ROLES[Seat(seat.role)], seat.status == Status.pending, tuple(seat.groups), may_leave)
    running = [pair for pair in shown if pair[0].stage in {Stage.open, Stage.late}]
    running.sort(key=lambda pair: (pair[0].rules.due_at is None, pair[0].rules.due_at or now))
    return OwnPage(
        head=views.head(course, place, "/eleves" if watched else ""),
        seat=own,
        staff=views.staff_rows(everyone, place, account),
        current=tuple(view for _, view in running),
        upcoming=tuple(view for one, view in shown if one.stage is Stage.upcoming),
        past=tuple(view for one, view in reversed(shown) if one.stage is Stage.closed),
        next=_next(running),
        zone=school_time.zone_name(),
        watched=watched.name if watched else "",
        watched_href=f"{views.href_of(place.school_class)}/eleves/{seat.account_id}/comme" if watched else "",
    )


def _assignment(course: Course, one: Mine, known: Results, by_hand: Mapping[str, Set], suffix: str) -> OwnAssignment:
    rules, assignment = one.rules, one.assignment
    exercises = (
        None
        if one.secret
        else tuple(_exercise(course, one, row, known, by_hand.get(row.exercise)) for row in one.exercises)
    )
    minutes = None if rules.duration is None else rules.duration.total_seconds() / 60
    href = f"/classes/{assignment.class_id}/devoirs/{assignment.id}/pourquoi{suffix}"
    return OwnAssignment(
        id=str(assignment.id),
        title=assignment.title,
        is_test=assignment.mode == Mode.test,
        stage=stage_view(one.stage),
        opens=when(rules.opens_at),
        due=when(rules.due_at),
        closes=when(rules.closes_at),
        late=_late(rules),
        excused=rules.excused,
        duration="" if minutes is None else words.duration(minutes),
        why_href=href,
        exercises=exercises,
        done=sum(row.kind == "done" for row in exercises or ()),
        differs=bool(one.exemptions),
    )


def _late(rules: Rules) -> str:
    """What becomes of what comes late; empty where nothing can."""
    ends_first = rules.closes_at is not None and rules.due_at is not None and rules.closes_at <= rules.due_at
    return "" if rules.due_at is None or ends_first else words.late_of(rules)


def _exercise(course: Course, one: Mine, row: AssignedExercise, known: Results, by_hand: Set | None) -> OwnExercise:
    exercise = course.exercises.get(row.exercise)
    title, href = (row.exercise, "") if exercise is None else (exercise.title, exercise_href(exercise))
    found = known[(one.assignment.id, row.exercise)]
    held = one.assignment.mode == Mode.test and not _released(one.assignment.released_at)
    kind, sign, told = _standing(found, held=held, over=one.stage is Stage.closed)
    if by_hand is not None and not held:
        kind, sign, told = _set_by_hand(by_hand)
        return OwnExercise(title, href, kind, sign, told, f"note de votre enseignant : {visible(by_hand.reason)}")
    late = found.counted.days_late if found.counted and not held else 0
    return OwnExercise(title, href, kind, sign, told, f"{plural(late, 'jour')} de retard" if late else "")


def _set_by_hand(found: Set) -> tuple[str, str, str]:
    """The same as `_standing`, of a mark that a teacher has set."""
    if found.points is None:
        return "excused", "–", "dispensé"
    full = found.points >= FULL - WHOLE
    return ("done", "✓", "réussi") if full else ("begun", "½", f"{mark(found.points)} / 20")


def _released(at: datetime | None) -> bool:
    return at is not None and at <= utc_now()


def _standing(found: Result, *, held: bool, over: bool = False) -> tuple[str, str, str]:
    """A name for the style, a sign, words. Of a test nothing is said before its teacher releases it."""
    if not found.attempts:
        return "new", "○", "pas fait" if over else "à faire"
    if held:
        return "sent", "•", f"envoyé, {plural(found.attempts, 'essai')}"
    counted = found.counted
    if counted is None:  # the best before the due date, where all came after it
        return "begun", "½", "rien avant la date de remise"
    if counted.full_points >= FULL - WHOLE:
        told = "réussi" if counted.points >= FULL - WHOLE else f"réussi : {mark(counted.points)} / 20"
        return "done", "✓", told
    return "begun", "½", f"{mark(counted.points)} / 20"


def _next(running: Sequence[tuple[Mine, OwnAssignment]]) -> NextThing | None:
    """The first exercise that is not solved, of the assignment that is due first."""
    for one, view in running:
        for row in () if one.rules.excused else view.exercises or ():
            if row.kind in {"new", "begun"} and row.href:
                return NextThing(row.href, row.title, view.title, row.kind == "begun")
    return None
