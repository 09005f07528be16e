"""A class as who learns there sees it: what is to be done, until when, what is done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import sitting_repository, student_assignments
from server.assignments.models import Mode, Sitting, WeightedExercise
from server.assignments.rules import MAX_POINTS, Rules
from server.assignments.stages import AssignmentStage
from server.assignments.student_assignments import StudentAssignment
from server.classes import repository
from server.classes.models import ClassRole, Membership, Status
from server.classes.schemas import Member
from server.course import Course
from server.database import utc_now
from server.desk import views
from server.desk.assignments import words
from server.desk.assignments.schemas import NextThing, OwnAssignment, OwnExercise, OwnPage, StageView
from server.desk.assignments.views import stage_view, when
from server.desk.own import sitting as tests
from server.desk.schemas import OwnSeat
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.marks import service as marks
from server.marks.means import format_points
from server.marks.schemas import ActiveOverride, ExerciseMark, OwnMark
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.text.plain import visible
from server.web import school_time
from server.web.views import exercise_href
from server.web.words import WHOLE, format_mark, plural

OPEN = ("open", "late", "done")
#: Of what is still open, where there is nothing left to do.
ALL_DONE = StageView("done", "✓", "tout est fait")
#: Of an exercise that a test asks for too: neither that it was done before nor that it was not.
HELD = ("sent", "•", "retenu le temps d’un contrôle")


@dataclass(frozen=True)
class _Known:
    """What there is to say of a student's work: marks and sittings by assignment; what was sent of what is held."""

    marks: Mapping[UUID, OwnMark]
    sittings: Mapping[UUID, Sitting]
    sent: Mapping[str, int]
    average: float | None
    now: datetime
    watched: bool


def own_page(db: Session, course: Course, place: ClassAccess, account: Account) -> OwnPage:
    """Of a member who is none of the staff."""
    membership = place.membership
    assert membership is not None  # who has no seat is an administrator, who sees the class as its staff do
    may_see, may_leave = place.has(Right.see_assignments), place.has(Right.leave_class)
    return _page(db, course, place, account, membership, may_see=may_see, may_leave=may_leave)


def watched_page(db: Session, course: Course, place: ClassAccess, account: Account, student: Member) -> OwnPage:
    """The page of a student, as their teacher looks at it: the same, with nothing to press."""
    return _page(db, course, place, account, student.membership, watched=student)


def _page(
    db: Session,
    course: Course,
    place: ClassAccess,
    account: Account,
    seat: Membership,
    *,
    may_see: bool = True,
    may_leave: bool = False,
    watched: Member | None = None,
) -> OwnPage:
    now = utc_now()
    found = (
        student_assignments.load_assignments_for_student(db, seat.class_id, seat.account_id, seat.groups, now)
        if may_see
        else ()
    )
    known = _known(db, course, place, seat.account_id, found, now, watched=watched is not None) if found else None
    suffix = "" if watched is None else f"?eleve={seat.account_id}"
    shown = [] if known is None else [(one, _assignment(course, one, known, suffix)) for one in found]
    own = OwnSeat(views.ROLES[ClassRole(seat.role)], seat.status == Status.pending, tuple(seat.groups), may_leave)
    running = sorted((pair for pair in shown if pair[1].stage.kind in OPEN), key=_urgency)
    return OwnPage(
        head=views.head(course, place, "/eleves" if watched else ""),
        seat=own,
        staff=views.staff_rows(repository.load_staff(db, place.school_class.id), place, account),
        current=tuple(view for _, view in running if view.stage.kind != ALL_DONE.kind),
        done=tuple(view for _, view in running if view.stage.kind == ALL_DONE.kind),
        upcoming=tuple(view for _, view in shown if view.stage.kind == "upcoming"),
        past=tuple(view for _, view in reversed(shown) if view.stage.kind == "closed"),
        next=_next(running),
        average="" if known is None or known.average is None else format_points(known.average),
        zone=school_time.time_zone_name(),
        watched=watched.name if watched else "",
        watched_href=f"{views.href_of(place.school_class)}/eleves/{seat.account_id}/comme" if watched else "",
    )


def _known(
    db: Session,
    course: Course,
    place: ClassAccess,
    account_id: UUID,
    found: Sequence[StudentAssignment],
    now: datetime,
    *,
    watched: bool,
) -> _Known:
    """What a student may know, asked of their account whoever looks: who watches sees no more."""
    own = marks.load_own_marks(db, course, place.school_class, account_id, now)
    held = gradebook.load_withholding_times(db, account_id)
    sat = (
        sitting_repository.load_account_sittings(db, account_id)
        if any(one.assignment.mode == Mode.test for one in found)
        else ()
    )
    return _Known(
        marks={one.assignment.id: one for one in own.marks},
        sittings={one.assignment_id: one for one, _ in sat},
        sent=gradebook.count_attempts_since(db, account_id, held) if held else {},
        average=own.average,
        now=now,
        watched=watched,
    )


def _urgency(pair: tuple[StudentAssignment, OwnAssignment]) -> tuple[bool, bool, str]:
    """Whoever sits a test finishes it; then what is due first."""
    view = pair[1]
    date = view.due.iso or (view.closes.iso if view.is_test else "")
    return not (view.test and view.test.running), not date, date


def _assignment(course: Course, one: StudentAssignment, known: _Known, suffix: str) -> OwnAssignment:
    rules, assignment = one.rules, one.assignment
    sitting = known.sittings.get(assignment.id)
    test = tests.view(assignment, rules, sitting, known.now) if assignment.mode == Mode.test else None
    stage = stage_view(one.stage) if test is None else test.stage
    exercises = (
        None
        if one.hides_exercises and sitting is None
        else tuple(_exercise(course, one, row, known, over=stage.kind == "closed") for row in one.exercises)
    )
    minutes = None if rules.duration is None else rules.duration.total_seconds() / 60
    done = sum(row.kind == "done" for row in exercises or ())
    left = any(row.kind not in {"done", "excused"} for row in exercises or ())
    all_done = (
        test is None and one.stage in {AssignmentStage.open, AssignmentStage.late} and bool(exercises) and not left
    )
    href = f"/classes/{assignment.class_id}/devoirs/{assignment.id}/pourquoi{suffix}"
    return OwnAssignment(
        id=str(assignment.id),
        title=assignment.title,
        is_test=test is not None,
        stage=ALL_DONE if all_done else stage,
        opens=when(rules.opens_at),
        due=when(rules.due_at),
        closes=when(rules.closes_at),
        late=_late(rules),
        excused=rules.excused,
        duration="" if minutes is None else words.duration(minutes),
        why_href=href,
        exercises=exercises,
        done=done,
        differs=bool(one.exemptions),
        test=test.as_seen(watched=known.watched) if test else None,
        mark=_mark(known.marks.get(assignment.id)) if stage.kind == "closed" else "",
    )


def _mark(found: OwnMark | None) -> str:
    """Of an assignment that is over; empty where there is none to tell."""
    points = None if found is None or found.mark is None else found.mark.points
    return "" if points is None else format_points(points)


def _late(rules: Rules) -> str:
    """What becomes of what comes late; empty where nothing can."""
    ends_first = rules.closes_at is not None and rules.due_at is not None and rules.closes_at <= rules.due_at
    return "" if rules.due_at is None or ends_first else words.late_of(rules)


def _exercise(
    course: Course, one: StudentAssignment, row: WeightedExercise, known: _Known, *, over: bool
) -> OwnExercise:
    exercise = course.exercises.get(row.exercise)
    title, href = (row.exercise, "") if exercise is None else (exercise.title, exercise_href(exercise))
    own = known.marks.get(one.assignment.id)
    found = None if own is None else own.exercises.get(row.exercise)
    if found is None:
        if one.assignment.mode != Mode.test:
            return OwnExercise(title, href, *HELD, "")
        sent = known.sent.get(row.exercise, 0) if one.assignment.id in known.sittings else 0
        return OwnExercise(title, href, *held_standing(sent, over=over), "")
    if found.override is not None:
        reason = visible(found.override.reason)
        return OwnExercise(title, href, *_set_by_hand(found.override), f"note de votre enseignant : {reason}")
    late = found.days_late
    return OwnExercise(title, href, *standing(found, over=over), f"{plural(late, 'jour')} de retard" if late else "")


def _set_by_hand(found: ActiveOverride) -> tuple[str, str, str]:
    """The same as `standing`, of a mark that a teacher has set."""
    if found.points is None:
        return "excused", "–", "dispensé"
    full = found.points >= MAX_POINTS - WHOLE
    return ("done", "✓", "réussi") if full else ("begun", "½", f"{format_mark(found.points)} / 20")


def held_standing(sent: int, *, over: bool) -> tuple[str, str, str]:
    """The same, of an exercise of which a test holds back what was found."""
    return ("sent", "•", "envoyé") if sent else ("new", "○", "pas fait" if over else "à faire")


def standing(found: ExerciseMark, *, over: bool) -> tuple[str, str, str]:
    """A name for the style, a sign, words."""
    if not found.attempts:
        return "new", "○", "pas fait" if over else "à faire"
    counted = found.counted
    if counted is None:  # the best before the due date, where all came after it
        return "begun", "½", "rien avant la date de remise"
    if counted.full_points >= MAX_POINTS - WHOLE:
        told = "réussi" if counted.points >= MAX_POINTS - WHOLE else f"réussi : {format_mark(counted.points)} / 20"
        return "done", "✓", told
    return "begun", "½", f"{format_mark(counted.points)} / 20"


def _next(running: Sequence[tuple[StudentAssignment, OwnAssignment]]) -> NextThing | None:
    """The test that is open; the first exercise that is not solved, of the assignment that is due first."""
    for one, view in running:
        if one.rules.excused and not (view.test and view.test.running):
            continue
        if view.test is not None:
            return NextThing(view.test.href, view.title, view.title, view.test.running, is_test=True)
        for row in view.exercises or ():
            if row.kind in {"new", "begun"} and row.href:
                return NextThing(row.href, row.title, view.title, row.kind == "begun")
    return None
