"""Failed attempts of a class, and a worker that asks their programs how they behave, in this process."""

from __future__ import annotations

from uuid import UUID

from sqlalchemy import func, select

from graders.core.contract.findings import Judgement
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis, Verdict
from server.base.settings import Settings
from server.behaviour.fingerprints import FINGERPRINT, FingerprintScheduler, FingerprintTask, PlaceFinder, StartProgram
from server.behaviour.models import Fingerprint
from server.course import Course
from server.database import Database, utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.identity.models import Account
from server.queue.worker import Worker
from server.submissions.models import Submission
from server.submissions.service import digest_code
from tests.support.quick import the_course
from tests.support.service import EXERCISE, QUIET

#: Three programs with one mistake, written otherwise, and one with another.
SUM = """
def composer(a, b):
    return np.asarray(a) + b

def inverse(a):
    return a

def relatif(a, b):
    return a
"""
SUM_AGAIN = "# Ada Lovelace\n" + SUM.replace("np.asarray(a) + b", "[a[k] + b[k] for k in range(3)]")
SUM_NEARLY = SUM.replace("np.asarray(a) + b", "(np.asarray(a) + b) * (1 + 1e-10)")
DIFFERENCE = SUM.replace("np.asarray(a) + b", "np.asarray(a) - b")


def failed_verdict(
    seed: int = 1, *, outcome: Outcome = Outcome.WRONG_ANSWER, named: str | None = None, version: str | None = None
) -> Verdict:
    """One check of two has failed."""
    shown = Counterexample({"a": [1, 2, 3]}, [0], [1])
    checks = [
        CheckResult("a", "Première", True, 10, 10),
        CheckResult("b", "Seconde", False, 0, 10, "Faux.", shown, "Que vaut θ₁ ?"),
    ]
    diagnosis = Diagnosis(named, "Une erreur connue", "Voici pourquoi.") if named else None
    current = the_course().exercises[EXERCISE].version
    return Verdict(EXERCISE, version or current, outcome, seed, checks, diagnosis)


def sent(database: Database, account: Account, code: str, verdict: Verdict | None = None) -> UUID:
    """An attempt of this account, graded."""
    with database.write() as db:
        source = code.encode()
        made = Submission(account_id=account.id, exercise=EXERCISE, source=source, digest=digest_code(code), seed=1)
        db.add(made)
        db.flush()
        gradebook.record_grading(db, made.id, GradingResult(Judgement(verdict or failed_verdict()), utc_now()))
    return made.id


def asking_worker(
    database: Database,
    settings: Settings,
    course: Course | None = None,
    start: StartProgram = lambda *_: LOCAL,
    find: PlaceFinder = lambda *_: None,
) -> Worker:
    """A worker to be stepped by hand, which searches no places of mistakes."""
    task = FingerprintTask(course or the_course(), QUIET, start, find)
    return Worker(database, QUIET, settings, {FINGERPRINT: task})


def ask_all(database: Database, settings: Settings, start: StartProgram = lambda *_: LOCAL) -> int:
    """Has every attempt asked that may be, for one look at what there is; how many jobs that took."""
    worker, steps = asking_worker(database, settings, start=start), 0
    FingerprintScheduler(database, QUIET, the_course()).queue_next()
    while worker.run_one():
        steps += 1
    return steps


def groups(database: Database) -> dict[UUID, str | None]:
    """The group of each submission that has a fingerprint."""
    with database.read() as db:
        query = select(Submission.id, Fingerprint.group_id).join(
            Fingerprint, Fingerprint.grading_id == Submission.grading_id
        )
        return {row[0]: row[1] for row in db.execute(query)}


def group_of(database: Database, submission: UUID) -> str:
    found = groups(database)[submission]
    assert found is not None
    return found


def fingerprints(database: Database) -> int:
    with database.read() as db:
        return db.execute(select(func.count()).select_from(Fingerprint)).scalar_one()
