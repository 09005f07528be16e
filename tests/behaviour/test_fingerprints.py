"""The job that asks failed programs how they behave: who is asked, when, and what may go wrong."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from uuid import UUID

import pytest
from sqlalchemy import delete, func, select, update

from graders.core.code.stored_answers import MAX_TOTAL_ITEMS
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Programs
from server.base.settings import Settings
from server.behaviour import repository
from server.behaviour.fingerprints import FINGERPRINT, SENDER, FingerprintScheduler, give_up_handlers
from server.behaviour.limits import tighten_limits
from server.behaviour.models import BehaviourGroup, Fingerprint
from server.classes.models import ClassRole, SchoolClass, Status
from server.database import Database, utc_now
from server.grading.sandbox_grader import SandboxPrograms
from server.identity.models import Account, Role
from server.queue.models import Job
from server.queue.service import MAX_TRIES
from server.sandbox import Policy, Sandbox
from server.submissions.models import Submission
from server.submissions.queue_senders import GUEST_RANK
from server.submissions.service import GRADE, SubmissionService
from tests.support.behaviour import (
    DIFFERENCE,
    SUM,
    SUM_AGAIN,
    SUM_NEARLY,
    ask_all,
    asking_worker,
    failed_verdict,
    fingerprints,
    group_of,
    groups,
    sent,
)
from tests.support.classes import new_class, seat
from tests.support.quick import the_course
from tests.support.service import ADDRESS, EXERCISE, QUIET, new_account


@pytest.fixture
def made(database: Database) -> SchoolClass:
    return new_class(database, new_account(database, Role.teacher, "Mme Martin"))


@pytest.fixture
def ada(database: Database, made: SchoolClass) -> Account:
    return seat(database, made, new_account(database))


@pytest.fixture
def bob(database: Database, made: SchoolClass) -> Account:
    return seat(database, made, new_account(database, name="Bob"))


def test_programs_with_equal_answers_share_a_group(
    database: Database, ada: Account, bob: Account, both: Settings
) -> None:
    first, again = sent(database, ada, SUM), sent(database, bob, SUM_AGAIN)
    nearly, other = sent(database, bob, SUM_NEARLY), sent(database, ada, DIFFERENCE)
    assert ask_all(database, both) == 4
    found = groups(database)
    assert found[first] == found[again] == found[nearly] is not None
    assert found[other] not in {found[first], None}
    with database.read() as db:
        group = db.get_one(BehaviourGroup, found[first])
    assert group.exercise == EXERCISE
    assert group.functions == ["composer", "inverse", "relatif"]
    assert group.example is not None
    assert group.example.keys() == {"function", "inputs", "expected", "got"}
    assert ask_all(database, both) == 0


def test_failed_attempts_of_students_are_observed(
    database: Database, made: SchoolClass, ada: Account, both: Settings
) -> None:
    """Failed attempts of students who are in a class, named or not; no other."""
    asked = {sent(database, ada, SUM), sent(database, ada, SUM, failed_verdict(named="known"))}
    sent(database, ada, SUM, failed_verdict(outcome=Outcome.SYNTAX_ERROR))
    sent(database, ada, SUM, failed_verdict(version="before"))
    sent(database, new_account(database, name="Alone"), SUM)
    sent(database, seat(database, made, new_account(database), ClassRole.assistant), SUM)
    sent(database, seat(database, made, new_account(database), status=Status.pending), SUM)
    assert ask_all(database, both) == 2
    assert groups(database).keys() == asked


def test_a_sweep_queues_one_job_behind_all_gradings(database: Database, ada: Account, both: Settings) -> None:
    for _ in range(3):
        sent(database, ada, SUM)
    scheduler = FingerprintScheduler(database, QUIET, the_course())
    scheduler.queue_next()
    scheduler.queue_next()
    with database.write() as db:
        assert db.execute(select(func.count()).select_from(Job)).scalar_one() == 1
        waiting = SubmissionService(both, QUIET).submit(db, ada, EXERCISE, "x = 1", address=ADDRESS)
    assert SENDER.rank > GUEST_RANK
    with database.write() as db:
        lease = QUIET.claim(db, asking_worker(database, both)._owner, [FINGERPRINT, GRADE], 60)
        assert lease is not None
        assert (lease.kind, lease.key) == (GRADE, str(waiting.id))


def test_sweeps_look_at_new_attempts_and_hourly_at_all(database: Database, made: SchoolClass, both: Settings) -> None:
    now = [utc_now()]
    scheduler = FingerprintScheduler(database, QUIET, the_course(), clock=lambda: now[0])
    scheduler.queue_next()
    late = new_account(database, name="Late")
    sent(database, late, SUM)
    now[0] += timedelta(minutes=30)
    scheduler.queue_next()
    seat(database, made, late)  # and what was sent before belongs to the class
    scheduler.queue_next()
    assert not asking_worker(database, both).run_one()
    now[0] += timedelta(minutes=31)
    scheduler.queue_next()
    assert asking_worker(database, both).run_one()


def test_an_attempt_deleted_before_or_during_its_job_leaves_nothing(
    database: Database, ada: Account, both: Settings
) -> None:
    def forgetting(_policy: Policy, _library: object) -> Programs:
        with database.write() as db:
            db.execute(update(Submission).values(grading_id=None))
            db.execute(delete(Account).where(Account.id == ada.id))
        return LOCAL

    sent(database, ada, SUM)
    FingerprintScheduler(database, QUIET, the_course()).queue_next()
    worker = asking_worker(database, both, start=forgetting)
    assert [worker.run_one(), worker.run_one()] == [True, False]
    assert fingerprints(database) == 0


def test_an_exercise_that_changed_meanwhile_is_not_observed(database: Database, ada: Account, both: Settings) -> None:
    sent(database, ada, SUM)
    FingerprintScheduler(database, QUIET, the_course()).queue_next()
    course, exercise = the_course(), the_course().exercises[EXERCISE]
    changed = replace(exercise, version="another")
    module = course.modules["l20"]
    others = tuple(changed if one.id == EXERCISE else one for one in module.exercises)
    newer = replace(course, modules={**course.modules, "l20": replace(module, exercises=others)})
    worker = asking_worker(database, both, newer)
    assert [worker.run_one(), worker.run_one()] == [True, False]
    assert fingerprints(database) == 0


def test_a_crashing_program_is_given_up_and_the_next_one_observed(
    database: Database, ada: Account, both: Settings, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(_policy: Policy) -> Programs:
        raise RuntimeError("a disk is full")

    lost = sent(database, ada, SUM)
    assert ask_all(database, both, broken) == MAX_TRIES
    assert groups(database) == {lost: None}
    assert "could not be asked" in caplog.text
    kept = sent(database, ada, SUM)
    assert ask_all(database, both) == 1
    assert groups(database)[kept] is not None
    assert give_up_handlers().keys() == {FINGERPRINT}


def test_programs_without_wrong_answers_share_groups_by_source_only(
    database: Database, ada: Account, bob: Account, both: Settings
) -> None:
    right = the_course().exercises[EXERCISE].solution
    one, same, other = (
        sent(database, who, code) for who, code in ((ada, right), (bob, right), (bob, right + "\nx = 1"))
    )
    assert ask_all(database, both) == 3
    found = groups(database)
    assert found[one] == found[same] is not None
    assert found[other] not in {found[one], None}


def test_a_program_that_only_lacks_a_function_has_no_group(database: Database, ada: Account, both: Settings) -> None:
    right = the_course().exercises[EXERCISE].solution
    lacking = sent(
        database, ada, right.replace("def relatif", "def autre"), failed_verdict(outcome=Outcome.MISSING_FUNCTION)
    )
    wrong = sent(
        database, ada, SUM.replace("def relatif", "def autre"), failed_verdict(outcome=Outcome.MISSING_FUNCTION)
    )
    ask_all(database, both)
    assert groups(database)[lacking] is None
    assert groups(database)[wrong] is not None


def test_empty_groups_are_deleted_unless_named(database: Database, ada: Account, both: Settings) -> None:
    sent(database, ada, SUM)
    ask_all(database, both)
    with database.write() as db:
        assert repository.delete_empty_groups(db) == 0
        db.execute(delete(Fingerprint))
        assert repository.delete_empty_groups(db) == 1


HOSTILE = {
    "draws": "import random\ndef composer(a, b):\n    return [random.random()] * 3\n",
    "draws, otherwise": "from random import random\ndef composer(a, b):\n    x = random()\n    return (x, x, x)\n",
    "draws from elsewhere": "import os\ndef composer(a, b):\n    return [float(int.from_bytes(os.urandom(6)))] * 3\n",
    "tells the time": "import time\ndef composer(a, b):\n    return [float(time.perf_counter_ns() % 10**6)] * 3\n",
    "huge": "def composer(a, b):\n    return np.zeros(10**5)\n",
    "huge, otherwise": "def composer(a, b):\n    return np.ones(10**5)\n",
    "beyond the wall": "def composer(a, b):\n    return np.zeros(10**7)\n",
    "never ends": "def composer(a, b):\n    while True:\n        pass\n",
    "deep": "def composer(a, b):\n    x = []\n    for _ in range(10**4):\n        x = [x]\n    return x\n",
    "dies": "import os\ndef composer(a, b):\n    os._exit(0)\n",
    "noise": "def composer(a, b):\n    return rng.random(1500)\ninverse = relatif = lambda *a: rng.random(1500)\n",
    "odd": "def composer(a, b):\n    return {'x' * 5000: [float('nan'), 1j, None, True, 10**400]}\n",
    "never loads": "while True:\n    pass\n",
}
REST = "\ndef inverse(a):\n    return [0.0, 0.0, 0.0]\n\ndef relatif(a, b):\n    return [0.0, 0.0, 0.0]\n"


def test_hostile_programs_are_grouped_within_bounds(sqlite: Database, settings: Settings) -> None:
    """What draws or reads the clock is known by its steady answers; what never loads, by its text."""
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    ada = seat(sqlite, made, new_account(sqlite))
    codes = {what: code if "relatif" in code else code + REST for what, code in HOSTILE.items()}
    ids = {what: sent(sqlite, ada, code) for what, code in codes.items()}
    course = the_course()
    with Sandbox(course.kits, spares=0) as sandbox:

        def start(policy: Policy, _library: object) -> SandboxPrograms:
            assert policy == tighten_limits(policy), "a program asked so has less time than for its verdict"
            return SandboxPrograms(sandbox, replace(policy, cpu_seconds=0.1, wall_seconds=1.0))

        assert ask_all(sqlite, settings, start) == len(ids)
    found: dict[str, str] = {what: group_of(sqlite, one) for what, one in ids.items()}
    assert found["draws"] == found["draws, otherwise"], "the sandbox has the same numbers drawn"
    assert found["draws from elsewhere"] == found["tells the time"]
    assert found["huge"] == found["huge, otherwise"], "no right answer is as large: it is known as that"
    different = (
        "draws",
        "tells the time",
        "huge",
        "beyond the wall",
        "never ends",
        "deep",
        "dies",
        "odd",
        "never loads",
    )
    assert len({found[what] for what in different}) >= len(different) - 1  # two may be stopped in the same way
    with sqlite.read() as db:
        sizes = db.execute(select(func.max(func.length(BehaviourGroup.answers)))).scalar_one()
    assert sizes < 10 * MAX_TOTAL_ITEMS


def test_the_older_of_two_near_groups_takes_a_program_between_them(
    database: Database, ada: Account, both: Settings
) -> None:
    """Equality up to a tolerance is not transitive: the order of coming decides, and stays."""

    def scaled(by: str) -> UUID:
        return sent(database, ada, SUM.replace("np.asarray(a) + b", f"(np.asarray(a) + b) * (1 + {by})"))

    low = scaled("0")
    ask_all(database, both)
    high = scaled("3e-7")
    ask_all(database, both)
    between = scaled("1e-8")
    ask_all(database, both)
    found = groups(database)
    assert found[low] != found[high]
    assert found[between] == found[low]
