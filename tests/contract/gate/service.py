"""A service as the gate measures it: on one machine, or on several; with a class, guests, and a teacher who attacks."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
from sqlalchemy import text

from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.classes.models import ClassRole
from server.classes.service import utc_now
from server.course import load_course
from server.database import Database
from server.identity import tokens
from server.identity.models import Account, BrowserSession, Role
from server.identity.secrets import draw_secret_token, hash_password, sha256_hex
from tests.contract.gate.attacker import Target
from tests.support.classes import assign, new_class, seat
from tests.support.live import Live, environment, until
from tests.support.service import new_account

EXERCISE = "l20/poses"
GUESTS = 20
#: What is bounded for each account is not what is measured.
WIDE = {
    f"BALISE_{name}_{what}": value
    for name in ("SUBMISSION", "STORAGE", "CELL", "STEP")
    for what, value in (("BURST", "100000"), ("REFILL_SECONDS", "0"))
}
#: What makes a process's number the one of its clock (Linux, `clock_getcpuclockid`).
PROCESS_CLOCK = 2
LOGIN, PASSWORD = "ada", "une phrase assez longue"


@dataclass(frozen=True)
class Member:
    """A member of the class: who they are to pages and to the API."""

    cookie: str
    token: str


@dataclass(frozen=True)
class Service:
    """A running service; the bystander's pages come from the first address, all addresses are attacked."""

    addresses: tuple[str, ...]
    database: Database
    student: Member
    teacher: Member
    class_id: str
    target: Target
    solution: str
    #: The web process that answers the bystander.
    web: int = 0

    def clear(self) -> None:
        """Forget what waits, and wait until nothing runs."""
        with self.database.write() as db:
            db.execute(text("DELETE FROM job WHERE lease_token IS NULL"))
        until(lambda: not self._count("SELECT count(*) FROM job"), "nothing runs")

    def processor(self) -> float:
        """Return the seconds of processor that the bystander's web process has used, all its threads together."""
        return time.clock_gettime((~self.web << 3) | PROCESS_CLOCK)

    def _count(self, query: str) -> int:
        with self.database.read() as db:
            return int(db.execute(text(query)).scalar_one())


@contextmanager
def one_machine(folder: Path, *, warm_figures: bool = True) -> Iterator[Service]:
    live = Live(folder / "data", BALISE_WARM_UP="1", BALISE_WARM_FIGURES=str(int(warm_figures)), **WIDE)
    try:
        settings = Settings(data_dir=folder / "data")
        with opened((live.address,), settings, live.process.pid) as service:
            yield service
    finally:
        end(live)


@contextmanager
def several_machines(folder: Path, database_url: str, nats_url: str) -> Iterator[Service]:
    """Two web processes without workers, and two workers that belong to neither."""
    values = {**WIDE, "BALISE_DATABASE_URL": database_url, "BALISE_NATS_URL": nats_url, "BALISE_WORKERS": "0"}
    values |= {"BALISE_WARM_UP": "1", "BALISE_WARM_FIGURES": "1"}
    with ExitStack() as stack:
        machines = []
        for name in ("one", "other"):
            (folder / name).mkdir()
            machines.append(Live(folder / name / "data", **values))
            stack.callback(end, machines[-1])
        log = stack.enter_context((folder / "workers.log").open("ab"))
        for _ in range(2):
            command = [sys.executable, "-m", "server", "worker"]
            worker = subprocess.Popen(command, stdout=log, stderr=log, env=environment(**values))
            stack.callback(worker.wait)
            stack.callback(worker.terminate)
        settings = Settings(data_dir=folder / "one" / "data", database_url=database_url)
        addresses = tuple(live.address for live in machines)
        yield stack.enter_context(opened(addresses, settings, machines[0].process.pid))


def end(live: Live) -> None:
    live.process.terminate()
    live.process.wait()
    live.close()


@contextmanager
def opened(addresses: tuple[str, ...], settings: Settings, web: int) -> Iterator[Service]:
    """A class on a running service, and who attacks it."""
    database, exercise = Database(settings.sqlalchemy_url), load_course(render=False).exercises[EXERCISE]
    teacher, student, attacker = (new_account(database, role) for role in (Role.teacher, Role.student, Role.teacher))
    hashed = hash_password(PASSWORD)
    with database.write() as db:
        account = db.get_one(Account, student.id)
        account.login, account.password_hash = LOGIN, hashed
    school_class, attacked = new_class(database, teacher), new_class(database, attacker, "PSI")
    seat(database, school_class, student)
    seat(database, school_class, teacher, ClassRole.teacher)
    assign(database, school_class, EXERCISE)
    guests = [member(database, settings, new_account(database, Role.guest)) for _ in range(GUESTS)]
    code = exercise.solution
    attempts = []
    with httpx.Client(base_url=addresses[0], timeout=120) as client:
        for guest in guests[:5]:
            sent = client.post(
                f"/{EXERCISE.replace('/', '/exercices/')}/soumissions",
                data={"code": f"{code}\ncomposer = lambda a, b: a + {len(attempts)}\n"},
                headers={"Cookie": guest.cookie},
            )
            attempts.append(sent.headers["Location"])
    target = Target(
        addresses,
        tuple(guest.cookie for guest in guests),
        member(database, settings, attacker).cookie,
        str(attacked.id),
        EXERCISE,
        code,
        tuple(attempts),
    )
    try:
        yield Service(
            addresses,
            database,
            member(database, settings, student),
            member(database, settings, teacher),
            str(school_class.id),
            target,
            code,
            web,
        )
    finally:
        database.close()


def member(database: Database, settings: Settings, account: Account) -> Member:
    cookie = draw_secret_token()
    with database.write() as db:
        _, secret = tokens.create_token(db, account, "essai", settings)
        ends = utc_now().replace(year=2100)
        db.add(BrowserSession(token_digest=sha256_hex(cookie), account_id=account.id, expires_at=ends))
    return Member(f"{SESSION_COOKIE}={cookie}", secret)
