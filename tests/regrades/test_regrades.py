"""Regrades: nothing counts before they are applied, all of it does then, and undoing leaves no trace in the marks."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from datetime import timedelta
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import UUID

import pytest
from hypothesis import HealthCheck, given
from hypothesis import settings as runs
from hypothesis import strategies as st
from sqlalchemy import delete, select

from server.app import ApplicationServices
from server.assignments.models import AssignedExercise, Assignment, LatePolicy, Mode, Sitting
from server.audit.models import AuditAction, AuditEvent
from server.base.errors import Conflict, Invalid, NotFound, ServiceError
from server.base.settings import Settings
from server.classes.models import ClassRole, Status
from server.database import Database, utc_now
from server.gradebook import repository as gradings
from server.gradebook import service as gradebook
from server.gradebook import standings
from server.gradebook.models import Grading, Standing
from server.gradebook.standings import StandingTotals
from server.grading.regrade_task import give_up_handlers
from server.identity import repository as identity
from server.identity.models import Account
from server.queue.models import Job
from server.queue.service import MAX_TRIES
from server.regrades import applying, repository, service
from server.regrades.models import Regrade, RegradeItem, RegradePolicy
from server.regrades.schemas import MarkChange, MarkOutcome, RegradeState
from server.regrades.service import REGRADE_JOB
from server.submissions.models import Submission
from server.submissions.service import GRADE, job_key
from tests.support.classes import seat
from tests.support.counting import Counted
from tests.support.quick import migrated
from tests.support.regrades import Lesson, Points, verdict
from tests.support.service import EXERCISE, QUIET, new_account


@pytest.fixture
def quick(sqlite: Database, settings: Settings) -> Lesson:
    return Lesson(sqlite, settings)


@pytest.fixture
def lesson(database: Database, both: Settings) -> Lesson:
    """On SQLite, then on PostgreSQL."""
    return Lesson(database, both)


def marks(lesson: Lesson) -> dict[UUID, StandingTotals]:
    with lesson.database.read() as db:
        found = {one.id: standings.load_account_standings(db, one.id, lesson.exercise) for one in lesson.students}
    return {student: by_exercise[lesson.exercise] for student, by_exercise in found.items() if by_exercise}


def best(lesson: Lesson) -> list[float]:
    """Points out of 20, by student."""
    found = marks(lesson)
    return [20 * found[one.id].best_score for one in lesson.students]


def apply(lesson: Lesson, regrade: Regrade) -> None:
    with lesson.database.write() as db:
        applying.apply_regrade(db, lesson.course, regrade.id, lesson.teacher.id)


def undo(lesson: Lesson, regrade: Regrade) -> None:
    with lesson.database.write() as db:
        applying.undo_regrade(db, lesson.course, regrade.id, lesson.teacher.id)


def seen(lesson: Lesson, regrade: Regrade) -> tuple[RegradeState, list[MarkChange]]:
    with lesson.database.read() as db:
        found = service.preview_regrade(db, service.find_regrade(db, lesson.made.id, regrade.id))
    order = [one.id for one in lesson.students]
    return found.progress.state, sorted(found.changes, key=lambda change: order.index(change.student))


def events(lesson: Lesson) -> list[tuple[str, UUID | None, dict[str, float], dict[str, float]]]:
    with lesson.database.read() as db:
        rows = db.execute(select(AuditEvent).order_by(AuditEvent.at)).scalars().all()
    return [(row.what, row.student, row.before, row.after) for row in rows]


def test_what_it_would_do_is_shown_then_done_then_undone(lesson: Lesson) -> None:
    lesson.arrive(4)
    ada, bob, eve, dan = lesson.students
    lesson.sent(ada, 4, 14)
    lesson.sent(ada, 8, 18)
    lesson.sent(bob, 16, 12)
    lesson.sent(eve, 10, 10)
    lesson.sent(dan, 10, None)
    before = marks(lesson)
    regrade = lesson.prepared(RegradePolicy.renew)
    assert marks(lesson) == before
    state, changes = seen(lesson, regrade)
    assert state is RegradeState.ready
    assert [(one.before, one.after, one.outcome) for one in changes] == [
        (8, 18, MarkOutcome.gains), (16, 12, MarkOutcome.loses), (10, 10, MarkOutcome.same), (10, 10, MarkOutcome.same),
    ]  # fmt: skip
    assert [[reason.kind for reason in one.differences] for one in changes] == [
        ["points"] * 2,
        ["points"],
        [],
        ["failed"],
    ]
    assert [one.failed for one in changes] == [0, 0, 0, 1]
    apply(lesson, regrade)
    apply(lesson, regrade)
    assert best(lesson) == [18, 12, 10, 10]
    assert seen(lesson, regrade) == (RegradeState.applied, changes)
    assert sorted(events(lesson), key=lambda one: one[1] != ada.id) == [
        (AuditAction.regrade_applied, ada.id, {"points": 8}, {"points": 18}),
        (AuditAction.regrade_applied, bob.id, {"points": 16}, {"points": 12}),
    ]
    undo(lesson, regrade)
    undo(lesson, regrade)
    assert marks(lesson) == before
    assert seen(lesson, regrade)[0] is RegradeState.undone
    with lesson.database.read() as db:
        assert not any(copy.is_applied for copy in repository.load_regraded_attempts(db, regrade.id))
    assert (AuditAction.regrade_undone, bob.id, {"points": 12}, {"points": 16}) in events(lesson)
    apply(lesson, regrade)
    assert best(lesson) == [18, 12, 10, 10]


def test_the_better_grading_is_kept_attempt_by_attempt(quick: Lesson) -> None:
    ada = quick.arrive()
    worse, equal, ours = quick.sent(ada, 16, 12), quick.sent(ada, 6, 6), quick.sent(ada, None, 3)
    regrade = quick.prepared(RegradePolicy.keep_best)
    (change,) = seen(quick, regrade)[1]
    assert (change.before, change.after, change.new_only, change.outcome) == (16, 16, 12, MarkOutcome.kept)
    assert change.submission_id == worse
    apply(quick, regrade)
    with quick.database.read() as db:
        counting = {name: gradings.list_gradings(db, name)[-1].id for name in (worse, equal, ours)}
        current = {row.id: row.grading_id for row in db.execute(select(Submission)).scalars()}
    assert {name: current[name] == counting[name] for name in counting} == {worse: False, equal: True, ours: True}
    assert marks(quick)[ada.id].attempts == 3
    assert events(quick) == [(AuditAction.regrade_applied, None, {}, {})]


def test_an_error_of_ours_never_replaces_anything(quick: Lesson) -> None:
    ada = quick.arrive()
    quick.sent(ada, 12, None)
    before = marks(quick)
    for policy in RegradePolicy:
        regrade = quick.prepared(policy)
        apply(quick, regrade)
        assert marks(quick) == before
        assert seen(quick, regrade)[1][0].failed == 1


def test_what_makes_the_marks_is_graded_first(quick: Lesson) -> None:
    ada, bob = quick.arrive(), quick.arrive()
    sent = [quick.sent(ada, points, 20) for points in (2, 14, 4, 6)] + [quick.sent(bob, 3, 20)]
    regrade = quick.start()
    quick.worker.run_one()
    assert (seen(quick, regrade)[0], seen(quick, regrade)[1][0].waiting) == (RegradeState.running, 3)
    with quick.database.read() as db:
        rows = db.execute(select(RegradeItem).order_by(RegradeItem.position)).scalars().all()
    assert [row.submission_id for row in rows] == [sent[1], sent[3], sent[4], sent[0], sent[2]]
    assert [row.counted for row in rows] == [True] * 3 + [False] * 2
    with pytest.raises(Conflict, match="encore 4"):
        apply(quick, regrade)
    assert quick.work() == 4
    apply(quick, regrade)


def test_who_is_a_student_of_the_class_and_has_sent_something_is_concerned(quick: Lesson) -> None:
    ada = quick.arrive()
    with pytest.raises(Invalid, match="rien à recorriger"):
        quick.start()
    quick.sent(ada, 2, 20)
    others = [
        seat(quick.database, quick.made, new_account(quick.database), ClassRole.assistant),
        seat(quick.database, quick.made, new_account(quick.database), status=Status.pending),
        seat(quick.database, quick.made, new_account(quick.database), status=Status.left, left_at=utc_now()),
        new_account(quick.database),
    ]
    for other in others:
        quick.sent(other, 2, 20)
    bob = quick.arrive()
    quick.sent(bob, 2, 20)
    one = quick.start(student=ada.id)
    with pytest.raises(Conflict, match="déjà en cours"):
        quick.start()
    assert quick.work() == 1
    assert [change.student for change in seen(quick, one)[1]] == [ada.id]
    every = quick.prepared()
    assert [change.student for change in seen(quick, every)[1]] == [ada.id, bob.id]
    with pytest.raises(NotFound, match="pas dans la classe"):
        quick.start(student=others[-1].id)
    with pytest.raises(Invalid, match="pas les deux"):
        quick.start(student=ada.id, assignment=ada.id)
    quick.exercise = "l20/none"
    with pytest.raises(NotFound, match="pas du module"):
        quick.start()


def test_an_assignment_has_its_own_dates_and_marks(quick: Lesson) -> None:
    ada = quick.arrive()
    early, late, after = quick.sent(ada, 20, 2), quick.sent(ada, 10, 12), quick.sent(ada, 4, 20)
    now = utc_now()
    with quick.database.write() as db:
        for name, when in ((early, -9), (late, -3), (after, 3)):
            row = db.get(Submission, name)
            assert row is not None
            row.created_at = now + timedelta(days=when)
        values = {"opens_at": now - timedelta(days=5), "due_at": now - timedelta(days=4), "closes_at": now}
        made = Assignment(class_id=quick.made.id, title="TP", late=LatePolicy.penalty, late_per_day=1.5, **values)
        db.add(made)
        db.flush()
        with pytest.raises(Invalid, match="pas dans ce devoir"), quick.database.read():
            service._build_regrade(
                db, quick.made, ada.id, service.RegradeInput(EXERCISE, RegradePolicy.renew, assignment=made.id)
            )
        db.add(AssignedExercise(assignment_id=made.id, exercise=EXERCISE, position=0))
    regrade = quick.prepared(RegradePolicy.renew, assignment=made.id)
    (change,) = seen(quick, regrade)[1]
    assert (change.attempts, change.before, change.after) == (2, 20.0, 10.5), "who worked ahead is on time"
    apply(quick, regrade)
    assert marks(quick)[ada.id].best_score == 0.6
    with quick.database.write() as db:
        db.execute(delete(Assignment))
    assert (quick.prepared(RegradePolicy.renew), seen(quick, regrade)[0]) != (None, RegradeState.ready)


def test_of_a_test_what_was_sent_while_one_sat_it_makes_the_mark(quick: Lesson) -> None:
    ada, now = quick.arrive(), utc_now()
    before, during, after = quick.sent(ada, 20, 2), quick.sent(ada, 10, 12), quick.sent(ada, 16, 20)
    with quick.database.write() as db:
        for name, when in ((before, -3), (during, -1), (after, 1)):
            row = db.get(Submission, name)
            assert row is not None
            row.created_at = now + timedelta(hours=when)
        made = Assignment(class_id=quick.made.id, title="Interro", mode=Mode.test, opens_at=now - timedelta(hours=9))
        db.add(made)
        db.flush()
        db.add(AssignedExercise(assignment_id=made.id, exercise=EXERCISE, position=0))
        db.add(Sitting(assignment_id=made.id, account_id=ada.id, began_at=now - timedelta(hours=2), handed_in_at=now))
    (change,) = seen(quick, quick.prepared(RegradePolicy.renew, assignment=made.id))[1]
    assert (change.attempts, change.before, change.after) == (1, 10.0, 12.0)


def test_overlapping_regrades_are_undone_in_the_other_order(quick: Lesson) -> None:
    ada = quick.arrive()
    quick.sent(ada, 4, 8)
    first = quick.prepared(RegradePolicy.renew)
    stale = quick.prepared(RegradePolicy.renew)
    start = marks(quick)
    apply(quick, first)
    middle = marks(quick)
    with pytest.raises(Conflict, match="entre-temps"):
        apply(quick, stale)
    quick.opinion = dict.fromkeys(quick.opinion, 12.0)
    second = quick.prepared(RegradePolicy.renew)
    apply(quick, second)
    with pytest.raises(Conflict, match="annulez-la d’abord"):
        undo(quick, first)
    assert best(quick) == [12]
    undo(quick, second)
    assert marks(quick) == middle
    undo(quick, first)
    assert marks(quick) == start
    apply(quick, stale)
    assert best(quick) == [8]


def test_two_versions_do_not_mix(quick: Lesson) -> None:
    ada = quick.arrive()
    quick.sent(ada, 4, 8)
    quick.sent(ada, 4, 9)
    regrade = quick.start()
    quick.worker.run_one()
    quick.version = "v3"
    quick.work()
    with pytest.raises(Conflict, match="deux versions"):
        apply(quick, regrade)


def test_what_is_sent_meanwhile_counts_as_it_is(quick: Lesson) -> None:
    ada = quick.arrive()
    quick.sent(ada, 4, 8)
    regrade = quick.prepared(RegradePolicy.renew)
    new = quick.sent(ada, 11)
    (change,) = seen(quick, regrade)[1]
    assert (change.before, change.after, change.sent_since) == (4, 8, 1)
    apply(quick, regrade)
    assert (best(quick), marks(quick)[ada.id].attempts) == ([11], 2)
    undo(quick, regrade)
    with quick.database.read() as db:
        (only,) = gradings.list_gradings(db, new)
    assert best(quick) == [11]
    assert only.exercise_version == "v1"


def test_who_erases_their_account_leaves_the_others_to_be_graded(lesson: Lesson) -> None:
    lesson.arrive(3)
    ada, bob, eve = lesson.students
    for student in lesson.students:
        lesson.sent(student, 4, 8)
    regrade = lesson.start(RegradePolicy.renew)
    lesson.worker.run_one()
    with lesson.database.write() as db:
        found = repository.load_next_item_to_grade(db, regrade.id)
        assert found is not None
        assert found[1].account_id == bob.id
        identity.delete_account(db, bob.id)
    assert lesson.work() == 1
    lesson.students = [ada, eve]
    assert [change.student for change in seen(lesson, regrade)[1]] == [ada.id, eve.id]
    apply(lesson, regrade)
    with lesson.database.write() as db:
        identity.delete_account(db, ada.id)
    lesson.students = [eve]
    undo(lesson, regrade)
    assert best(lesson) == [4]


def test_an_account_that_goes_while_it_is_graded_keeps_nothing(lesson: Lesson) -> None:
    ada, bob = lesson.arrive(), lesson.arrive()
    lesson.sent(ada, 4, 8)
    lesson.sent(bob, 4, 8)
    regrade = lesson.start()
    usual = lesson.grade
    worker = lesson.worker

    def erasing(file: object) -> object:
        with lesson.database.write() as db:
            identity.delete_account(db, ada.id)
        return usual(file)  # type: ignore[arg-type]

    worker._tasks["regrade"]._grade = erasing
    assert worker.run_one()
    assert lesson.work() == 1
    lesson.students = [bob]
    assert seen(lesson, regrade)[0] is RegradeState.ready
    with lesson.database.read() as db:
        assert len(db.execute(select(Grading)).all()) == 2


def test_a_stopped_regrade_ends_and_is_never_applied(quick: Lesson) -> None:
    ada = quick.arrive()
    for _ in range(3):
        quick.sent(ada, 4, 8)
    regrade = quick.start()
    quick.worker.run_one()
    with quick.database.write() as db:
        service.stop_regrade(db, regrade.id)
    assert quick.work() == 1  # which finds nothing to do
    assert seen(quick, regrade)[0] is RegradeState.stopped
    with pytest.raises(Conflict, match="arrêtée"):
        apply(quick, regrade)
    with quick.database.read() as db:
        assert db.execute(select(Job)).first() is None


def test_what_ends_its_workers_is_given_up_and_the_others_are_graded(quick: Lesson) -> None:
    ada, bob = quick.arrive(), quick.arrive()
    quick.sent(ada, 4, 8)
    quick.sent(bob, 4, 8)
    regrade = quick.start()
    worker = quick.worker
    for _ in range(MAX_TRIES):
        with quick.database.write() as db:
            assert QUIET.claim(db, worker._owner, ["regrade"], 30)
        with quick.database.write() as db:
            assert QUIET.recover_from(db, worker._owner, give_up_handlers(quick.course, QUIET)) == 1
    assert quick.work() == 1
    state, changes = seen(quick, regrade)
    assert (state, [change.failed for change in changes]) == (RegradeState.ready, [1, 0])


def test_the_service_knows_the_end_of_what_regrades_put(quick: Lesson) -> None:
    """Else a regrade would wait for ever behind a job that was lost with its worker."""
    assert {GRADE, REGRADE_JOB} <= ApplicationServices(quick.settings, quick.course, ()).give_up_handlers.keys()


def test_a_guest_who_makes_an_account_takes_the_regrade_along(lesson: Lesson) -> None:
    guest, account = lesson.arrive(), lesson.arrive()
    lesson.sent(guest, 4, 8)
    lesson.sent(account, 6, 6)
    regrade = lesson.prepared()
    apply(lesson, regrade)
    with lesson.database.write() as db:
        gradebook.move_guest_attempts(db, guest.id, account.id)
        identity.delete_account(db, guest.id)
    lesson.students = [account]
    assert best(lesson) == [8]
    undo(lesson, regrade)
    assert (best(lesson), marks(lesson)[account.id].attempts) == ([6], 2)


class Crash(Exception):
    """Something fails in the middle."""


def test_a_crash_in_the_middle_of_applying_changes_nothing(quick: Lesson, monkeypatch: pytest.MonkeyPatch) -> None:
    quick.arrive(3)
    for student in quick.students:
        quick.sent(student, 4, 8)
    before, regrade = marks(quick), quick.prepared()

    def crash(*_: object, **__: object) -> None:
        raise Crash

    with monkeypatch.context() as patch:
        patch.setattr("server.audit.service.record_event", crash)
        with pytest.raises(Crash):
            apply(quick, regrade)
    assert marks(quick) == before
    assert seen(quick, regrade)[0] is RegradeState.ready
    apply(quick, regrade)
    assert best(quick) == [8, 8, 8]


def test_students_send_while_it_is_applied_and_undone_again_and_again(lesson: Lesson) -> None:
    lesson.arrive(3)
    for student in lesson.students:
        lesson.sent(student, 4, 8)
    regrade = lesson.prepared()

    def send(number: int) -> None:
        lesson.sent(lesson.students[number % 3], 5)

    def settle(number: int) -> None:
        (undo if number % 2 else apply)(lesson, regrade)

    with ThreadPoolExecutor(4) as pool:
        for future in [pool.submit(one, number) for number in range(8) for one in (send, settle)]:
            future.result()
    apply(lesson, regrade)
    with lesson.database.write() as db:
        assert [gradebook.rebuild_account_standings(db, one.id) for one in lesson.students] == [0, 0, 0]
    assert sum(sums.attempts for sums in marks(lesson).values()) == 11
    assert best(lesson) == [8, 8, 8]


def test_a_student_never_waits_for_more_than_the_job_that_is_being_done(quick: Lesson) -> None:
    """And the regrades of two classes go in turns."""
    other = Lesson(quick.database, quick.settings)
    for one in (quick, other):
        student = one.arrive()
        for _ in range(4):
            one.sent(student, 4, 8)
    quick.opinion |= other.opinion
    begun = []
    worker = quick.worker
    usual = quick.grade

    def grade(file: object) -> object:
        begun.append(file.submission_id)  # type: ignore[attr-defined]
        return usual(file)  # type: ignore[arg-type]

    for task in worker._tasks.values():
        task._grade = grade
    quick.start()
    other.start()
    for _ in range(3):
        worker.run_one()
    with quick.database.write() as db:
        row = Submission(account_id=student.id, exercise=EXERCISE, source=b"x", digest="d", seed=1)
        db.add(row)
        db.flush()
        QUIET.enqueue(db, GRADE, job_key(row.id))
        assert QUIET.position(db, GRADE, job_key(row.id)) == 1
    while worker.run_one():
        pass
    assert begun.index(row.id) == 3
    of_first = [name in quick.opinion and name not in other.opinion for name in begun if name != row.id]
    assert of_first == [True, False] * 4


def test_an_author_is_told_while_it_is_applied(quick: Lesson) -> None:
    ada = quick.arrive()
    name = quick.sent(ada, 4, 14)
    regrade = quick.prepared()

    def told() -> tuple[float | None, float | None] | None:
        with quick.database.read() as db:
            attempt = gradebook.find_attempt(db, ada, name)
            assert attempt.grading is not None
            found = service.find_applied_regrade(db, attempt.grading.id)
        return None if found is None else (found.before, found.after)

    assert told() is None
    apply(quick, regrade)
    assert told() == (0.2, 0.7)
    undo(quick, regrade)
    assert told() is None


def test_attempts_of_an_older_version_are_counted_until_they_are_graded_anew(lesson: Lesson) -> None:
    lesson.version = lesson.course.version_of_exercise(EXERCISE)
    ada, bob = lesson.arrive(), lesson.arrive()
    for student, points in ((ada, 4.0), (ada, 9.0), (bob, 3.0)):
        lesson.sent(student, points, 2.0)
    lesson.sent(new_account(lesson.database), 4)

    def outdated() -> list[tuple[str, int, int]]:
        with lesson.database.read() as db:
            return [
                (one.exercise, one.attempts, one.students)
                for one in lesson.regrades.load_outdated_exercises(db, lesson.made)
            ]

    assert outdated() == [(EXERCISE, 3, 2)]
    usual, lesson.opinion = lesson.opinion, dict.fromkeys(lesson.opinion)
    lesson.prepared(student=bob.id)
    assert outdated() == [(EXERCISE, 3, 2)]  # for it was an error of ours
    lesson.opinion = usual
    lesson.prepared(student=bob.id)
    assert outdated() == [(EXERCISE, 2, 1)]
    lesson.prepared()  # though every grading that counts is the old one
    assert outdated() == []


def test_a_preview_asks_as_much_for_many_students_as_for_one(quick: Lesson) -> None:
    asked = []
    for count in (1, 12):
        quick.arrive(count)
        for student in quick.students[-count:]:
            quick.sent(student, 4, 8)
        regrade = quick.start()
        while quick.worker.run_one():
            pass
        with Counted(quick.database) as counted:
            seen(quick, regrade)
        with Counted(quick.database) as applied:
            apply(quick, regrade)
        assert not any("grading.verdict" in one or "grading.figures" in one for one in counted.statements)
        asked.append((len(counted.statements), len([one for one in applied.statements if "SELECT" in one])))
    assert asked[0] == asked[1]


SCORE = st.sampled_from([0.0, 4.0, 10.0, 15.0, 20.0, None])
STEP = st.one_of(
    st.tuples(st.just("send"), st.integers(0, 2), SCORE, SCORE),
    st.tuples(st.just("send"), st.integers(0, 2), SCORE, SCORE),
    st.tuples(st.just("prepare"), st.sampled_from(list(RegradePolicy)), st.integers(-1, 2)),
    st.tuples(st.just("work"), st.integers(1, 6)),
    st.tuples(st.just("apply"), st.integers(0, 5)),
    st.tuples(st.just("undo"), st.integers(0, 5)),
)


class Story:
    """A class, and what ought to count in it, kept in the plainest way: pointers, and where they were."""

    def __init__(self, lesson: Lesson) -> None:
        self.lesson = lesson
        lesson.arrive(3)
        self.points: dict[UUID, Points] = {}
        self.authors: dict[UUID, UUID] = {}
        self.regrades: list[tuple[Regrade, RegradePolicy, dict[UUID, Points]]] = []
        self.applied: dict[UUID, dict[UUID, Points]] = {}

    def send(self, who: int, points: Points, anew: Points) -> None:
        student = self.lesson.students[who]
        name = self.lesson.sent(student, points, anew)
        self.points[name], self.authors[name] = points, student.id

    def prepare(self, policy: RegradePolicy, who: int) -> None:
        scope = {} if who < 0 else {"student": self.lesson.students[who].id}
        mine = [name for name, author in self.authors.items() if author in scope.values() or not scope]
        try:
            made = self.lesson.start(policy, **scope)
        except (Invalid, Conflict):
            return
        self.regrades.append((made, policy, {name: self.lesson.opinion[name] for name in mine}))

    def work(self, steps: int) -> None:
        worker = self.lesson.worker
        for _ in range(steps):
            worker.run_one()

    def apply(self, which: int) -> None:
        if not self.regrades:
            return
        made, policy, anew = self.regrades[which % len(self.regrades)]
        try:
            apply(self.lesson, made)
        except ServiceError:
            return
        if made.id in self.applied:
            return
        self.applied[made.id] = {}
        for name, points in anew.items():
            old = self.points[name]
            if points is not None and (policy is RegradePolicy.renew or old is None or points >= old):
                self.applied[made.id][name], self.points[name] = old, points

    def undo(self, which: int) -> None:
        if not self.regrades:
            return
        made = self.regrades[which % len(self.regrades)][0]
        try:
            undo(self.lesson, made)
        except ServiceError:
            return
        self.points |= self.applied.pop(made.id, {})

    def check(self) -> None:
        found = marks(self.lesson)
        for student in self.lesson.students:
            mine = [points for name, points in self.points.items() if self.authors[name] == student.id]
            counted = [points for points in mine if points is not None]
            kept = found.get(student.id)
            told = None if kept is None else (20 * kept.best_score, kept.attempts, kept.last_outcome)
            last = verdict(counted[-1]).outcome.value if counted else ""
            assert told == ((max(counted), len(counted), last) if counted else None)

    def end(self) -> None:
        """Undone from the last to the first, everything is as it was before any of it."""
        with self.lesson.database.read() as db:
            rows = db.execute(select(Submission.id, Submission.grading_id)).all()
            oldest = {name: gradings.list_gradings(db, name)[0].id for name, _ in rows}
        for made in reversed(list(self.applied)):
            undo(self.lesson, next(one for one, *_ in self.regrades if one.id == made))
        with self.lesson.database.write() as db:
            assert dict(db.execute(select(Submission.id, Submission.grading_id)).all()) == oldest
            kept = db.execute(select(Standing.__table__).order_by(Standing.account_id)).all()
            db.execute(delete(Standing))
            for student in self.lesson.students:
                gradebook.rebuild_account_standings(db, student.id)
            assert db.execute(select(Standing.__table__).order_by(Standing.account_id)).all() == kept


def tell(lesson: Lesson, steps: list[tuple[object, ...]]) -> None:
    story = Story(lesson)
    for name, *arguments in steps:
        getattr(story, str(name))(*arguments)
        story.check()
    story.end()


def in_a_file(steps: list[tuple[object, ...]]) -> None:
    with TemporaryDirectory() as folder:
        settings = Settings(data_dir=Path(folder), workers=0)
        with closing(migrated(settings)) as database:
            tell(Lesson(database, settings), steps)


@given(st.lists(STEP, min_size=6, max_size=20))
@runs(max_examples=5, deadline=None, database=None)
def test_any_history_of_regrades_is_undone_without_a_trace(steps: list[tuple[object, ...]]) -> None:
    in_a_file(steps)


@pytest.mark.slow
@given(st.lists(STEP, min_size=10, max_size=60))
@runs(max_examples=150, deadline=None, database=None)
def test_any_long_history_of_regrades_is_undone_without_a_trace(steps: list[tuple[object, ...]]) -> None:
    in_a_file(steps)


@pytest.fixture
def on_postgres(settings: Settings, postgres_url: str) -> Iterator[Lesson]:
    url = settings.model_copy(update={"database_url": postgres_url})
    with closing(migrated(url)) as database:
        yield Lesson(database, url)
        with database.write() as db:
            db.execute(delete(Regrade))
            db.execute(delete(Account))


@pytest.mark.contract
@given(st.lists(STEP, min_size=6, max_size=12))
@runs(max_examples=2, deadline=None, database=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_history_is_undone_without_a_trace_on_postgresql(
    on_postgres: Lesson, steps: list[tuple[object, ...]]
) -> None:
    with on_postgres.database.write() as db:
        db.execute(delete(Regrade))
        db.execute(delete(Job))
        db.execute(delete(Account).where(Account.id != on_postgres.teacher.id))
    on_postgres.students.clear()
    tell(on_postgres, steps)
