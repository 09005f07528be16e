"""Writes the class and its history: accounts, assignments, attempts graded in the sandbox as any other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from random import Random
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.findings import Judgement
from server.assignments.models import Assignment
from server.base.settings import Settings
from server.classes import repository as classes_stored
from server.classes import service as classes
from server.classes.models import ClassRole, Membership, SchoolClass
from server.course import Course, Module
from server.database import Database, utc_now
from server.demo import teaching
from server.demo.people import SimulatedStudent, draw_simulated_students
from server.demo.programs import format_as_student_file
from server.demo.story import PlannedAttempt, lesson_start_times, plan_attempts
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.identity import secrets
from server.identity.models import Account, Role
from server.submissions.models import Submission
from server.submissions.service import digest_code
from server.submissions.variants import get_or_create_seed

CLASS_NAME = "MPSI 2 (démonstration)"
TEACHER = ("martin", "Claire Martin")
ASSISTANT = ("nguyen", "Paul Nguyen")
WEEK = timedelta(days=7)
GRADING_TIME = timedelta(milliseconds=60)
BATCH_SIZE = 100  # attempts written in one transaction

Grade = Callable[[str, bytes, int], Judgement]
ProgressCallback = Callable[[int, int], None]


@dataclass(frozen=True)
class DemoClass:
    """The class as it was written: passwords of who may enter, and what the lesson still brings."""

    class_id: UUID
    logins: Mapping[str, str]
    upcoming: Sequence[PlannedAttempt]
    accounts: Sequence[UUID]
    seeds: Mapping[str, int]


def choose_demo_module(course: Course) -> Module:
    """The module that a demonstration is of: the one with the most exercises."""
    return max(course.modules.values(), key=lambda module: len(module.exercises))


def create_demo_class(
    database: Database,
    course: Course,
    module: Module,
    grade: Grade,
    settings: Settings,
    *,
    seed: int,
    students: int,
    report_progress: ProgressCallback,
) -> DemoClass:
    """Into an empty database. `grade` says the judgement of a file; `told` hears how many attempts are written."""
    random, now = Random(seed), utc_now()
    everyone = draw_simulated_students(random, students)
    steps = plan_attempts(module, everyone, random, now)
    seeds = {exercise.id: random.getrandbits(50) for exercise in module.exercises}
    logins = {login: secrets.draw_secret_token()[:12] for login in (TEACHER[0], everyone[0].login)}
    hashes = {login: secrets.hash_password(password) for login, password in logins.items()}
    with database.write() as db:
        made, teacher, accounts = _create_class_and_accounts(db, module, everyone, hashes, now)
        room = teaching.DemoClassroom(course, module, made, teacher, accounts)
        test = teaching.create_assignments(db, room, now)
    past = [step for step in steps if step.sent_at <= now]
    _grade_and_record_attempts(database, course, past, accounts, seeds, grade, report_progress)
    with database.write() as db:
        room = replace(room, school_class=db.get_one(SchoolClass, made.id), teacher=db.get_one(Account, teacher.id))
        teaching.record_test_sittings(db, room, db.get_one(Assignment, test.id), past)
        teaching.write_example_comments(db, room, past, settings)
        teaching.create_oral_marks_column(db, room, now)
        teaching.record_lessons_with_presence(db, room, now)
    return DemoClass(made.id, logins, [step for step in steps if step.sent_at > now], accounts, seeds)


def _create_class_and_accounts(
    db: Session, module: Module, pupils: Sequence[SimulatedStudent], hashes: Mapping[str, str], now: datetime
) -> tuple[SchoolClass, Account, list[UUID]]:
    first = lesson_start_times(now)[0]
    teacher = _create_account(db, *TEACHER, Role.teacher, hashes)
    assistant = _create_account(db, *ASSISTANT, Role.teacher, hashes)
    made = classes.create_class(db, teacher, CLASS_NAME, module.slug)
    made.created_at = first - WEEK
    db.add(Membership(class_id=made.id, account_id=assistant.id, role=ClassRole.assistant))
    accounts = [_enrol_student(db, made, pupil, first, hashes) for pupil in pupils]
    return made, teacher, accounts


def _create_account(db: Session, login: str, name: str, role: Role, hashes: Mapping[str, str]) -> Account:
    account = Account(login=login, name=name, role=role, password_hash=hashes.get(login))
    db.add(account)
    db.flush()
    return account


def _enrol_student(
    db: Session, school_class: SchoolClass, pupil: SimulatedStudent, since: datetime, hashes: Mapping[str, str]
) -> UUID:
    account = _create_account(db, pupil.login, pupil.name, Role.student, hashes)
    row = Membership(
        class_id=school_class.id,
        account_id=account.id,
        family_name=pupil.family,
        given_name=pupil.given,
        email=f"{pupil.login}@exemple.fr",
        groups=[pupil.group],
        joined_at=since,
        created_by_list=True,
    )
    db.add(row)
    return account.id


def attempt_source(step: PlannedAttempt, seed: int, *, code: bool) -> bytes:
    """The file of an attempt. The same program again differs from itself, as what students send does."""
    source = step.submission.source_for_seed(seed)
    return format_as_student_file(source, step.repeats) if code else source


def _grade_and_record_attempts(
    database: Database,
    course: Course,
    planned_attempts: Sequence[PlannedAttempt],
    accounts: Sequence[UUID],
    seeds: Mapping[str, int],
    grade: Grade,
    report_progress: ProgressCallback,
) -> None:
    """The same file of code on the same seed is graded once; answers are to each student's own deal."""
    judged: dict[tuple[str, bytes, int], Judgement] = {}
    for start in range(0, len(planned_attempts), BATCH_SIZE):
        with database.write() as db:
            for step in planned_attempts[start : start + BATCH_SIZE]:
                exercise, account = course.exercises[step.exercise], db.get_one(Account, accounts[step.pupil])
                code = exercise.kind == "code"
                seed = seeds[step.exercise] if code else get_or_create_seed(db, account, step.exercise)
                source = attempt_source(step, seed, code=code)
                key = (step.exercise, source, seed)
                if key not in judged:
                    judged[key] = grade(*key)
                _record_attempt(db, account, step, source, seed, judged[key])
        report_progress(min(start + BATCH_SIZE, len(planned_attempts)), len(planned_attempts))


def _record_attempt(
    db: Session, account: Account, step: PlannedAttempt, source: bytes, seed: int, judgement: Judgement
) -> None:
    text = source.decode("utf-8", errors="replace")
    row = Submission(
        account_id=account.id,
        exercise=step.exercise,
        source=source,
        digest=digest_code(text),
        seed=seed,
        created_at=step.sent_at,
    )
    db.add(row)
    db.flush()
    gradebook.record_grading(db, row.id, GradingResult(judgement, step.sent_at, step.sent_at + GRADING_TIME))
    classes_stored.update_last_seen(db, account.id, step.sent_at, step.sent_at)
