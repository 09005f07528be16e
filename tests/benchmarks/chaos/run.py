"""One run, from the first process to the last table."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from server.base.settings import Settings
from server.course import load_course
from server.database import Database
from server.identity import tokens
from server.identity.models import Account, Role
from tests.benchmarks.chaos import report, truth
from tests.benchmarks.chaos.faults import Fault, Monkey
from tests.benchmarks.chaos.park import Park
from tests.benchmarks.chaos.students import Attempt, Crowd, Ledger, Program

EXERCISE = "l20/poses"
THINK = 0.1  # seconds
#: Of what is sent, the part before the first fault, by which the rest is measured.
CALM, MOST_CALM = 0.06, 100


@dataclass(frozen=True)
class Plan:
    submissions: int
    students: int
    seed: int
    every: float
    only: frozenset[str] = frozenset()
    seconds: float = 3600.0
    alone: bool = False


def programs() -> Sequence[Program]:
    exercise = load_course(render=False).exercises[EXERCISE]
    return [Program(exercise.solution, "ok"), Program(exercise.grader.misconceptions[0].source, "wrong_answer")]


def accounts(database: Database, count: int) -> dict[str, str]:
    """Students, each with a token."""
    found, settings = {}, Settings(workers=0)
    for number in range(count):
        with database.write() as db:
            account = Account(role=Role.student, name=f"Élève {number}", login=f"eleve{number}")
            db.add(account)
            db.flush()
            found[str(account.id)] = tokens.create_token(db, account, "essai", settings)[1]
    return found


def run(plan: Plan, folder: Path) -> int:
    folder.chmod(0o755)  # PostgreSQL runs under another user, where it would be root
    park, ledger = Park(folder), Ledger()
    try:
        park.start()
        database = Database(park.postgres.url.replace("postgresql://", "postgresql+psycopg://"))
        monkey, calm, drain = story(plan, park, database, ledger)
        problems = [*truth.broken(database, ledger, may_give_up=True)]
        database.close()
    finally:
        left = park.close()
    problems += [f"processes were left: {left}"] if left else []
    problems += [f"{one.kind} of {one.part}: {one.trouble}" for one in monkey.faults if one.trouble]
    tell(park, ledger, monkey, calm, drain)
    print(f"\n{len(problems)} promises broken" + "".join(f"\n  {one}" for one in problems[:40]))
    return 1 if problems else 0


def story(plan: Plan, park: Park, database: Database, ledger: Ledger) -> tuple[Monkey, int, float]:
    """A calm beginning, then the faults; how many were sent before the first, and what it took to be done after the
    last."""
    crowd = Crowd([web.address for web in park.webs], EXERCISE, programs(), ledger, THINK)
    everyone, calm = accounts(database, plan.students), min(MOST_CALM, int(CALM * plan.submissions))
    asyncio.run(crowd.send(everyone, calm, plan.seed))

    def over(fault: Fault) -> bool:
        """It has ended, who waited then has been told, and all parts are back."""
        waited = ledger.waiting_at(fault.begun)
        ended = fault.ended < time.monotonic() and all(one.told < float("inf") for one in waited)
        return ended and all(part.ready() for part in (*park.webs, *park.workers))

    monkey = Monkey(park, plan.seed, plan.every, plan.only, over if plan.alone else None)
    crowd.close(plan.seconds)
    ending = threading.Timer(plan.seconds, monkey.tell)
    monkey.start()
    ending.start()
    try:
        asyncio.run(crowd.send(everyone, plan.submissions - calm, plan.seed + 1))
    finally:
        ending.cancel()
        monkey.stop()
    return monkey, calm, truth.drained(database)


def tell(park: Park, ledger: Ledger, monkey: Monkey, calm: int, drain: float) -> None:
    phases: list[tuple[str, Sequence[Attempt]]] = [
        ("calm", ledger.attempts[:calm]),
        ("one fault after the other" if monkey.over else f"a fault each {monkey.every:g} s", ledger.attempts[calm:]),
    ]
    print(report.of_latency(phases))
    print(report.of_faults(ledger, monkey.faults))
    print(f"failed requests: {report.of_failures(ledger.failures)}")
    given_up = sum(one.outcome == "internal_error" for one in ledger.attempts)
    print(f"given up as an error of ours: {given_up}; drained {drain:.1f} s after the last fault has ended")
    for part in park.parts:
        print(f"{part.name}: {'ended by itself with ' + str(part.fallen) if part.fallen else 'never ended by itself'}")
    print("\n".join(report.of_logs([part.log for part in park.parts])))
    seconds = max(one.told for one in ledger.attempts) - min(one.begun for one in ledger.attempts)
    print(f"{len(ledger.attempts)} submissions and {len(monkey.faults)} faults in {seconds:.0f} s")
