"""Marks that go to a platform: its gradebook equals ours in the end, whatever it answers meanwhile."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from itertools import pairwise
from random import Random
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import delete, select, update

from server.assignments.models import AssignedExercise, Assignment, Mode
from server.classes.models import ClassRole, Membership, SchoolClass
from server.course import Course
from server.database import Database, utc_now
from server.federation import outbox_repository
from server.federation.errors import OutgoingError
from server.federation.lti import registration
from server.federation.models import DeliveryState, LineItem, MarkDelivery, ProviderContext, SigningKey
from server.federation.outbox import GONE
from server.federation.outbox_task import (
    MAX_FAILURES,
    NO_SERVICE,
    THREADS,
    CourseMarksWork,
    OutboxThread,
    SchoolMarksTask,
)
from server.federation.outgoing import Outgoing
from server.identity.models import Account, FederatedIdentity, Role
from server.marks.models import Override, StateDecision
from server.queue.lease_owner import process_owner
from tests.support.classes import person
from tests.support.client import TestClient
from tests.support.platform_gradebook import PlatformGradebook
from tests.support.platforms import AGS, Platform, our_private_pem
from tests.support.service import EXERCISE, Site
from tests.support.tables import folded

SCOPES = [f"{AGS}scope/lineitem", f"{AGS}scope/score"]


@dataclass
class Stage:
    """A class tied to a course of a platform, with assignments that are over and students who have marks there."""

    database: Database
    course: Course
    book: PlatformGradebook = field(default_factory=PlatformGradebook)
    platform: Platform = field(default_factory=Platform)
    now: datetime = field(default_factory=utc_now)

    def build(self, students: int = 3, assignments: int = 1) -> Stage:
        self.platform.handlers["/items"] = self.book.handle
        with self.database.write() as db:
            texts = {"name": "Moodle", "issuer": self.platform.issuer, "client_id": "balise"}
            db.add(SigningKey(private_pem=our_private_pem(), created_at=self.now))
            self.provider = registration.add_platform(db, texts, self.platform.settings, None)
            self.made = SchoolClass(name="MPSI", module="l20")
            db.add(self.made)
            db.flush()
            items = f"{self.platform.issuer}/items?type_id=3"
            self.context = ProviderContext(
                provider_id=self.provider.id, context="c", class_id=self.made.id, line_items_url=items, scopes=SCOPES
            )
            db.add(self.context)
            self.students = [Account(role=Role.student, name=f"Élève {number}") for number in range(students)]
            db.add_all(self.students)
            self.assignments = [
                Assignment(
                    class_id=self.made.id, title=f"DM {number}", opens_at=self.now - timedelta(days=9),
                    due_at=self.now - timedelta(days=1), closes_at=self.now - timedelta(days=1),
                )
                for number in range(assignments)
            ]  # fmt: skip
            db.add_all(self.assignments)
            db.flush()
            for assignment in self.assignments:
                db.add(AssignedExercise(assignment_id=assignment.id, exercise=EXERCISE, position=0))
                outbox_repository.add_line_item(db, self.context.id, assignment.id, self.now)
            for student in self.students:
                db.add(Membership(class_id=self.made.id, account_id=student.id))
                identity = {"issuer": self.platform.issuer, "subject": f"s-{student.name}"}
                db.add(FederatedIdentity(account_id=student.id, **identity))
        self.task = SchoolMarksTask(
            self.database, self.course, Outgoing(exchange=self.platform.exchange), lambda: self.now
        )
        return self

    def mark(self, student: int, assignment: int, points: float) -> None:
        row = {"exercise": EXERCISE, "assignment_id": self.assignments[assignment].id, "reason": "x", "based_on": []}
        with self.database.write() as db:
            db.execute(delete(Override).where(
                Override.account_id == self.students[student].id, Override.assignment_id == row["assignment_id"]
            ))  # fmt: skip
            db.add(Override(class_id=self.made.id, account_id=self.students[student].id, points=points, **row))

    def mark_all(self, random: Random) -> None:
        with self.database.write() as db:
            db.execute(delete(Override))
            for assignment in self.assignments:
                for student in self.students:
                    row: dict[str, Any] = {"exercise": EXERCISE, "assignment_id": assignment.id}
                    points = random.randrange(0, 81) / 4
                    db.add(Override(class_id=self.made.id, account_id=student.id, points=points, reason="x",
                                    based_on=[], **row))  # fmt: skip

    def run(self) -> datetime:
        with self.database.read() as db:
            context = db.get(ProviderContext, self.context.id)
        assert context is not None
        return self.task.run(CourseMarksWork(context, self.provider))

    def run_until_nothing_waits(self, rounds: int = 500) -> int:
        for number in range(rounds):
            later = self.run()
            if not self.states().get(DeliveryState.waiting):
                return number
            self.now = max(later, self.now + timedelta(seconds=1))
        raise AssertionError(self.deliveries()[:3])

    def deliveries(self) -> Sequence[MarkDelivery]:
        with self.database.read() as db:
            return db.execute(select(MarkDelivery)).scalars().all()

    def states(self) -> Mapping[str, int]:
        states = [delivery.state for delivery in self.deliveries()]
        return {state: states.count(state) for state in set(states)}

    def expected(self) -> Mapping[tuple[str, str], float]:
        with self.database.read() as db:
            rows = db.execute(select(Override.assignment_id, Override.account_id, Override.points))
            names = {student.id: f"s-{student.name}" for student in self.students}
            return {(str(row[0]), names[row[1]]): row[2] for row in rows}


@pytest.fixture
def stage(sqlite: Database, course: Course) -> Stage:
    return Stage(sqlite, course)


def test_each_final_mark_is_sent_once_to_one_column(stage: Stage) -> None:
    stage.build(students=3, assignments=3)
    stage.mark_all(Random(1))
    with stage.database.write() as db:
        db.execute(delete(Override).where(Override.account_id == stage.students[2].id))
    stage.run()
    stage.run()
    assert stage.book.marks == stage.expected()
    assert len(stage.book.scores) == 6
    assert sorted(item["label"] for item in stage.book.items.values()) == ["DM 0", "DM 1", "DM 2"]
    score = stage.book.scores[0]
    assert (score["activityProgress"], score["gradingProgress"], score["scoreMaximum"]) == (
        "Completed",
        "FullyGraded",
        20,
    )
    assert ("POST", "/items/0/scores") in stage.platform.requests


def test_the_platform_equals_the_book_after_errors_conflicts_and_lost_answers(stage: Stage) -> None:
    stage.book.fault_rate = 0.4
    stage.build(students=9, assignments=4)
    random = Random(2)
    for _ in range(2):
        stage.mark_all(random)
        stage.run_until_nothing_waits()
        assert stage.book.marks == stage.expected()
    assert {200, 500, 503, 429} <= set(stage.book.statuses)
    assert len(stage.book.items) == 4
    assert stage.states() == {DeliveryState.sent: 36}


@pytest.mark.slow
def test_ten_thousand_marks_arrive_through_a_platform_that_fails(stage: Stage) -> None:
    stage.book.fault_rate = 0.3
    stage.build(students=500, assignments=20)
    stage.mark_all(Random(4))
    stage.run_until_nothing_waits(5000)
    assert len(stage.book.marks) == 10_000
    assert stage.book.marks == stage.expected()


def test_a_platform_that_hangs_holds_up_no_other_school(stage: Stage) -> None:
    """A call that nobody answers takes twelve seconds of the thread in which all schools' marks are sent."""
    stage.build(students=40)
    for student in range(40):
        stage.mark(student, 0, 10)
    stage.run_until_nothing_waits()
    for student in range(40):
        stage.mark(student, 0, 11)
    asked = []

    def hang(*_: Any) -> Any:
        asked.append(1)
        raise OutgoingError("pas de réponse à temps", retry=True)

    stage.platform.handlers["/items"] = hang
    stage.run()
    assert len(asked) < MAX_FAILURES + THREADS
    stage.platform.handlers["/items"] = stage.book.handle
    stage.run_until_nothing_waits()
    assert set(stage.book.marks.values()) == {11}


def test_a_clock_that_was_ahead_is_overtaken(stage: Stage) -> None:
    """After a restored backup the platform may have later timestamps than ours."""
    stage.build(students=1)
    stage.mark(0, 0, 12.0)
    stage.run_until_nothing_waits()
    key = (str(stage.assignments[0].id), "s-Élève 0")
    stage.book.seen_at[key] += 500
    stage.mark(0, 0, 13.0)
    stage.run_until_nothing_waits()
    assert stage.book.marks[key] == 13.0
    assert 409 in stage.book.statuses


def withhold(stage: Stage) -> None:
    with stage.database.write() as db:
        db.execute(update(Assignment).values(mode=Mode.test, duration_minutes=60))


def open_again(stage: Stage) -> None:
    with stage.database.write() as db:
        later = stage.now + timedelta(days=2)
        db.execute(update(Assignment).values(due_at=later, closes_at=later))


def endless(stage: Stage) -> None:
    with stage.database.write() as db:
        db.execute(update(Assignment).values(due_at=None, closes_at=None))


def nothing(stage: Stage) -> None:
    with stage.database.write() as db:
        db.execute(delete(Override))


def excuse(stage: Stage) -> None:
    decide(stage, "excused")


def absent(stage: Stage) -> None:
    decide(stage, "absent")


def decide(stage: Stage, state: str) -> None:
    row = {"assignment_id": stage.assignments[0].id, "state": state, "reason": "x"}
    with stage.database.write() as db:
        db.add(StateDecision(account_id=stage.students[0].id, **row))


@folded("change", [withhold, open_again, endless, nothing, excuse, absent])
def test_nothing_is_sent_for_nothing_nor_before_it_is_final(change: Any, sqlite: Database, course: Course) -> None:
    stage = fresh(sqlite, course)
    stage.mark(0, 0, 12.0)
    change(stage)
    stage.run()
    assert stage.book.scores == []
    assert stage.deliveries() == []
    assert stage.book.items == {}


@folded("change", [withhold, nothing, excuse])
def test_nothing_goes_over_a_mark_that_was_sent(change: Any, sqlite: Database, course: Course) -> None:
    stage = fresh(sqlite, course)
    stage.mark(0, 0, 12.0)
    stage.run()
    change(stage)
    stage.run()
    assert list(stage.book.marks.values()) == [12.0]
    (delivery,) = stage.deliveries()
    assert (delivery.state, delivery.reason, delivery.sent_points) == (DeliveryState.refused, GONE, 12.0)


def fresh(database: Database, course: Course) -> Stage:
    """Return a stage in an emptied database."""
    with database.write() as db:
        for table in (
            MarkDelivery,
            LineItem,
            ProviderContext,
            Override,
            StateDecision,
            Assignment,
            SchoolClass,
            Account,
        ):
            db.execute(delete(table))
        from server.federation.models import IdentityProvider

        db.execute(delete(IdentityProvider))
    return Stage(database, course).build(students=1)


def test_a_zero_that_a_teacher_decides_is_sent(stage: Stage) -> None:
    stage.build(students=1)
    decide(stage, "zero")
    stage.run()
    assert list(stage.book.marks.values()) == [0.0]


def test_who_is_not_in_the_course_is_refused_and_may_be_sent_again(stage: Stage) -> None:
    stage.build(students=2)
    stage.book.strangers = {"s-Élève 0"}
    stage.mark_all(Random(1))
    stage.run()
    assert stage.states() == {DeliveryState.refused: 1, DeliveryState.sent: 1}
    (refused,) = [each for each in stage.deliveries() if each.state == DeliveryState.refused]
    assert "400" in refused.reason
    stage.book.strangers = set()
    stage.run()
    assert stage.states()[DeliveryState.refused] == 1
    with stage.database.write() as db:
        assert outbox_repository.requeue_deliveries(db, [refused.line_item_id], refused.account_id, stage.now) == 1
    stage.run()
    assert stage.book.marks == stage.expected()


def test_a_column_that_was_deleted_is_made_anew(stage: Stage) -> None:
    stage.build(students=1)
    stage.mark(0, 0, 12.0)
    stage.run()
    stage.book.items.clear()
    stage.book.items["/items/other"] = {"id": f"{stage.platform.issuer}/items/other", "resourceId": "other"}
    stage.mark(0, 0, 13.0)
    stage.run_until_nothing_waits()
    assert list(stage.book.marks.values()) == [13.0]
    assert len(stage.book.items) == 2


@folded("case", ["no scope", "no service", "another site's service", "another site's item"])
def test_addresses_and_scopes_are_those_of_the_platform(case: str, sqlite: Database, course: Course) -> None:
    stage = fresh(sqlite, course)
    stage.mark(0, 0, 12.0)
    changes = {
        "no scope": {"scopes": SCOPES[1:]},
        "no service": {"line_items_url": ""},
        "another site's service": {"line_items_url": "https://evil.example/items"},
    }
    if case in changes:
        with stage.database.write() as db:
            db.execute(update(ProviderContext).values(**changes[case]))
    else:
        item = {"id": "https://evil.example/items/1", "resourceId": str(stage.assignments[0].id)}
        stage.book.items["/items/1"] = item
    stage.run()
    with stage.database.read() as db:
        (line_item,) = db.execute(select(LineItem)).scalars()
    assert line_item.url is None
    assert (line_item.problem == NO_SERVICE) == (case in {"no scope", "no service"})
    assert "autre site" in line_item.problem or line_item.problem == NO_SERVICE
    assert stage.book.scores == []


def test_the_thread_of_a_worker_sends_what_is_due_and_one_of_two_does(database: Database, course: Course) -> None:
    stage = Stage(database, course).build(students=2)
    stage.mark_all(Random(1))
    from server.base.settings import Settings

    settings = Settings(workers=0)
    threads = [OutboxThread(database, settings, stage.task, process_owner(1 + number)) for number in range(2)]
    for thread in threads:
        thread.work()
    assert stage.book.marks == stage.expected()
    assert len(stage.book.scores) == 2
    with database.read() as db:
        assert not outbox_repository.has_due_line_items(db, utc_now())


def test_timestamps_of_a_student_are_later_by_a_second(stage: Stage) -> None:
    stage.build(students=1)
    for number in range(5):
        stage.mark(0, 0, float(number))
        stage.run()
    times = [datetime.fromisoformat(score["timestamp"]) for score in stage.book.scores]
    assert all(later - earlier >= timedelta(seconds=1) for earlier, later in pairwise(times))
    assert set(stage.book.statuses) <= {200, 201}
    assert UUID(stage.book.items["/items/0"]["resourceId"]) == stage.assignments[0].id


def test_a_teacher_sees_each_state_sends_again_and_unties(site: Site, course: Course) -> None:
    stage = Stage(site.database, course).build(students=2)
    stage.book.strangers = {"s-Élève 0"}
    stage.mark_all(Random(1))
    stage.run()
    teacher = person(site, Role.teacher, "Grace")
    with site.database.write() as db:
        db.add(Membership(class_id=stage.made.id, account_id=teacher.account.id, role=ClassRole.teacher))
    client = TestClient(site.app, cookies=teacher.cookies, follow_redirects=False)
    address = f"/classes/{stage.made.id}/plateforme"
    page = client.get(address).text
    assert "1 note envoyée, 0 en attente, 1 refusée" in page
    assert "réponse 400" in page
    form = {"cours": str(stage.context.id), "devoir": str(stage.assignments[0].id)}
    stage.book.strangers = set()
    assert client.post(address, data={**form, "action": "renvoyer"}).status_code == 303
    stage.now += timedelta(minutes=1)
    stage.run()
    assert stage.book.marks == stage.expected()
    assert client.post(address, data={**form, "action": "arreter"}).status_code == 303
    assert stage.deliveries() == []
    assert client.post(address, data={**form, "action": "envoyer"}).status_code == 303
    assert client.post(address, data={**form, "action": "delier"}).status_code == 303
    assert "Aucun cours" in client.get(address).text
    assert "délié" in client.get(f"/classes/{stage.made.id}/journal").text
