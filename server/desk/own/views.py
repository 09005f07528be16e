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
from server.assignments.team_rules import team_word
from server.base import school_time
from server.classes import repository
from server.classes.models import ClassRole, Membership, Status
from server.classes.schemas import Member
from server.course import Course
from server.database import utc_now
from server.desk import views
from server.desk.assignments import words
from server.desk.assignments.schemas import (
    NextStep,
    OwnAssignment,
    OwnClassPage,
    OwnExercise,
    OwnTeam,
    RubricNotice,
    StageView,
)
from server.desk.assignments.views import format_date, stage_view
from server.desk.own.lesson import find_own_lesson, find_own_warm_up
from server.desk.own.sitting_status import find_sitting_status
from server.desk.schemas import OwnMembership
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.marks import service as marks
from server.marks.means import format_points
from server.marks.own import VisibleMark, VisibleMarks, describe_assignment_mark
from server.marks.rubrics_repository import load_rubric_titles
from server.marks.schemas import ActiveDecision, ActiveOverride, ExerciseMark
from server.marks.states import STATE_WORDS, UNMARKED_STATES, MarkState
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.text.plain import show_invisible_characters
from server.web.views import exercise_href
from server.web.words import WHOLE, count_with_noun, format_mark

OPEN_STAGES = ("open", "late", "done")
#: Of what is still open, where there is nothing left to do.
ALL_DONE = StageView("done", "✓", "tout est fait")
#: Of an exercise that a test asks for too: neither that it was done before nor that it was not.
WITHHELD_STANDING = ("sent", "•", "retenu le temps d’un contrôle")


@dataclass(frozen=True)
class _StudentWork:
    """What there is to say of a student's work: marks and sittings by assignment; what was sent of what is held."""

    marks: Mapping[UUID, VisibleMark]
    sittings: Mapping[UUID, Sitting]
    sent: Mapping[str, int]
    rubrics: Mapping[UUID, tuple[str, bool]]
    now: datetime
    watched: bool


def build_own_page(db: Session, course: Course, access: ClassAccess, account: Account) -> OwnClassPage:
    """Of a member who is none of the staff."""
    membership = access.membership
    assert membership is not None  # who has no seat is an administrator, who sees the class as its staff do
    may_see, may_leave = access.has(Right.see_assignments), access.has(Right.leave_class)
    return _build_page(db, course, access, account, membership, may_see=may_see, may_leave=may_leave)


def build_watched_page(
    db: Session, course: Course, access: ClassAccess, account: Account, student: Member
) -> OwnClassPage:
    """The page of a student, as their teacher looks at it: the same, with nothing to press."""
    return _build_page(db, course, access, account, student.membership, watched=student)


def _build_page(
    db: Session,
    course: Course,
    access: ClassAccess,
    account: Account,
    seat: Membership,
    *,
    may_see: bool = True,
    may_leave: bool = False,
    watched: Member | None = None,
) -> OwnClassPage:
    now = utc_now()
    found = (
        student_assignments.load_assignments_for_student(db, seat.class_id, seat.account_id, seat.groups, now)
        if may_see
        else ()
    )
    own_marks = marks.load_visible_marks(db, course, access.school_class, seat.account_id, now) if may_see else None
    known = (
        _load_student_work(db, seat.account_id, found, own_marks, now, watched=watched is not None)
        if own_marks is not None and found
        else None
    )
    suffix = "" if watched is None else f"?eleve={seat.account_id}"
    shown = (
        [] if known is None else [(assigned, _own_assignment(course, assigned, known, suffix)) for assigned in found]
    )
    own = OwnMembership(views.ROLES[ClassRole(seat.role)], seat.status == Status.pending, tuple(seat.groups), may_leave)
    running = sorted((pair for pair in shown if pair[1].stage.kind in OPEN_STAGES), key=_urgency_sort_key)
    return OwnClassPage(
        head=views.class_head(course, access, "/eleves" if watched else ""),
        seat=own,
        staff=views.active_staff(repository.load_staff(db, access.school_class.id)),
        current=tuple(view for _, view in running if view.stage.kind != ALL_DONE.kind),
        done=tuple(view for _, view in running if view.stage.kind == ALL_DONE.kind),
        upcoming=tuple(view for _, view in shown if view.stage.kind == "upcoming"),
        past=tuple(view for _, view in reversed(shown) if view.stage.kind == "closed"),
        next=_choose_next_step(running),
        average="" if own_marks is None or own_marks.average is None else format_points(own_marks.average),
        marks=own_marks,
        zone=school_time.time_zone_name(),
        warm_up=find_own_warm_up(db, access, seat.account_id) if may_see else None,
        lesson=find_own_lesson(db, course, seat.class_id, seat.account_id, now) if may_see else None,
        watched=watched.name if watched else "",
    )


def _load_student_work(
    db: Session,
    account_id: UUID,
    found: Sequence[StudentAssignment],
    own: VisibleMarks,
    now: datetime,
    *,
    watched: bool,
) -> _StudentWork:
    """What a student may know, asked of their account whoever looks: who watches sees no more."""
    held = gradebook.load_withholding_times(db, account_id)
    sat = (
        sitting_repository.load_account_sittings(db, account_id)
        if any(assigned.assignment.mode == Mode.test for assigned in found)
        else ()
    )
    return _StudentWork(
        marks={mark.assignment.id: mark for mark in own.marks},
        sittings={sitting.assignment_id: sitting for sitting, _ in sat},
        sent=gradebook.count_attempts_since(db, account_id, held) if held else {},
        rubrics=load_rubric_titles(db, [assigned.assignment.id for assigned in found]),
        now=now,
        watched=watched,
    )


def _urgency_sort_key(pair: tuple[StudentAssignment, OwnAssignment]) -> tuple[bool, bool, str]:
    """Whoever sits a test finishes it; then what is due first."""
    view = pair[1]
    date = view.due.iso or (view.closes.iso if view.is_test else "")
    return not (view.test and view.test.running), not date, date


def _own_assignment(course: Course, assigned: StudentAssignment, known: _StudentWork, suffix: str) -> OwnAssignment:
    rules, assignment = assigned.rules, assigned.assignment
    sitting = known.sittings.get(assignment.id)
    test = find_sitting_status(assignment, rules, sitting, known.now) if assignment.mode == Mode.test else None
    stage = stage_view(assigned.stage) if test is None else test.stage
    exercises = (
        None
        if assigned.hides_exercises and sitting is None
        else tuple(
            _own_exercise(course, assigned, row, known, over=stage.kind == "closed") for row in assigned.exercises
        )
    )
    minutes = None if rules.duration is None else rules.duration.total_seconds() / 60
    done = sum(row.kind == "done" for row in exercises or ())
    left = any(row.kind not in {"done", "excused"} for row in exercises or ())
    all_done = (
        test is None and assigned.stage in {AssignmentStage.open, AssignmentStage.late} and bool(exercises) and not left
    )
    href = f"/classes/{assignment.class_id}/devoirs/{assignment.id}/pourquoi{suffix}"
    return OwnAssignment(
        id=str(assignment.id),
        title=assignment.title,
        is_test=test is not None,
        stage=ALL_DONE if all_done else stage,
        opens=format_date(rules.opens_at),
        due=format_date(rules.due_at),
        closes=format_date(rules.closes_at),
        late=_late_policy_text(rules),
        excused=rules.excused,
        duration="" if minutes is None else words.format_duration(minutes),
        why_href=href,
        exercises=exercises,
        done=done,
        differs=bool(assigned.exemptions),
        test=test.for_viewer(watched=known.watched) if test else None,
        mark=_final_mark_text(known.marks.get(assignment.id), over=stage.kind == "closed"),
        decision=_active_decision(known.marks.get(assignment.id)),
        rubric=RubricNotice(*known.rubrics[assignment.id]) if assignment.id in known.rubrics else None,
        team=_own_team(assigned, "" if known.watched else href.replace("/pourquoi", "/mon-equipe")),
        copy_href="" if exercises is None or known.watched else href.replace("/pourquoi", "/copie"),
    )


def _own_team(assigned: StudentAssignment, href: str) -> OwnTeam | None:
    assignment = assigned.assignment
    if assignment.team_size < 2:
        return None
    partners = tuple(partner.name for partner in assigned.partners)
    return OwnTeam(team_word(assignment.team_size), partners, assignment.teams_by_students, href)


def _final_mark_text(found: VisibleMark | None, *, over: bool) -> str:
    """Return the mark of an assignment that is over, or decided, in words; empty where there is none to tell."""
    mark = None if found is None else found.mark
    if mark is None or not (over or mark.decision is not None):
        return ""
    text = describe_assignment_mark(mark)
    if mark.state not in UNMARKED_STATES:
        return text
    return f"{text} ({'compte 0' if mark.points_in_average is not None else 'ne compte pas'} dans la moyenne)"


def _active_decision(found: VisibleMark | None) -> ActiveDecision | None:
    return None if found is None or found.mark is None else found.mark.decision


def _late_policy_text(rules: Rules) -> str:
    """What becomes of what comes late; empty where nothing can."""
    ends_first = rules.closes_at is not None and rules.due_at is not None and rules.closes_at <= rules.due_at
    return "" if rules.due_at is None or ends_first else words.describe_late_rules(rules)


def _own_exercise(
    course: Course, assigned: StudentAssignment, row: WeightedExercise, known: _StudentWork, *, over: bool
) -> OwnExercise:
    exercise = course.exercises.get(row.exercise)
    title, href = (row.exercise, "") if exercise is None else (exercise.title, exercise_href(exercise))
    own = known.marks.get(assigned.assignment.id)
    found = None if own is None else own.exercises.get(row.exercise)
    if found is None:
        if assigned.assignment.mode != Mode.test:
            return OwnExercise(title, href, *WITHHELD_STANDING, "")
        sent = known.sent.get(row.exercise, 0) if assigned.assignment.id in known.sittings else 0
        return OwnExercise(title, href, *withheld_standing(sent, over=over), "")
    if found.override is not None:
        reason = show_invisible_characters(found.override.reason)
        return OwnExercise(title, href, *_override_standing(found.override), f"note de votre enseignant : {reason}")
    late = found.days_late
    return OwnExercise(
        title, href, *exercise_standing(found, over=over), f"{count_with_noun(late, 'jour')} de retard" if late else ""
    )


def _override_standing(found: ActiveOverride) -> tuple[str, str, str]:
    """The same as `standing`, of a mark that a teacher has set."""
    if found.points is None:
        return "excused", "–", "dispensé"
    full = found.points >= MAX_POINTS - WHOLE
    return ("done", "✓", "réussi") if full else ("begun", "½", f"{format_mark(found.points)} / 20")


def withheld_standing(sent: int, *, over: bool) -> tuple[str, str, str]:
    """The same, of an exercise of which a test holds back what was found."""
    words = STATE_WORDS[MarkState.not_handed_in] if over else "à faire"
    return ("sent", "•", "envoyé") if sent else ("new", "○", words)


def exercise_standing(found: ExerciseMark, *, over: bool) -> tuple[str, str, str]:
    """A name for the style, a sign, words."""
    if not found.attempts:
        if found.is_refused_as_late:
            return "refused", "✗", STATE_WORDS[MarkState.late_refused]
        return "new", "○", STATE_WORDS[MarkState.not_handed_in] if over else "à faire"
    counted = found.counted
    if counted is None:  # the best before the due date, where all came after it
        return "begun", "½", "rien avant la date de remise"
    if counted.full_points >= MAX_POINTS - WHOLE:
        told = "réussi" if counted.points >= MAX_POINTS - WHOLE else f"réussi : {format_mark(counted.points)} / 20"
        return "done", "✓", told
    return "begun", "½", f"{format_mark(counted.points)} / 20"


def _choose_next_step(running: Sequence[tuple[StudentAssignment, OwnAssignment]]) -> NextStep | None:
    """The test that is open; the first exercise that is not solved, of the assignment that is due first."""
    for assigned, view in running:
        if assigned.rules.excused and not (view.test and view.test.running):
            continue
        if view.test is not None:
            return NextStep(view.test.href, view.title, view.title, view.test.running, is_test=True)
        for row in view.exercises or ():
            if row.kind in {"new", "begun"} and row.href:
                return NextStep(row.href, row.title, view.title, row.kind == "begun")
    return None
