"""A database as the version before jobs and gradings left it, with one of everything that it may hold."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any
from uuid import UUID, uuid4

import sqlalchemy as sa
from sqlalchemy import Connection, Engine

from graders.core.contract.outcomes import Outcome
from server.database.engine import writing_engine
from server.database.migrate import upgrade
from server.identity.secrets import sha256_hex

BEFORE = "0002"
POSES, ANSWERS = "l20/poses", "l20/calcul_odometrie"
NOON = datetime(2026, 3, 1, 12, tzinfo=UTC)
LATER = datetime(2100, 1, 1, tzinfo=UTC)
OWNER = "elsewhere|boot|pid:[1]|7|1"
NAMED = {"id": "rotation_oubliee", "title": "Sans rotation", "explanation": "Ah."}
MANY = 230  # more than are copied at once

_TIME = sa.DateTime(timezone=True)
_TYPES: dict[str, Any] = {
    "id": sa.Uuid(), "account_id": sa.Uuid(), "lease_token": sa.Uuid(), "opened_by": sa.Uuid(),
    "created_at": _TIME, "started_at": _TIME, "finished_at": _TIME, "expires_at": _TIME, "lease_until": _TIME,
    "opened_at": _TIME, "verdict": sa.JSON(none_as_null=True), "figures": sa.JSON(none_as_null=True),
}  # fmt: skip


def _insert(connection: Connection, table: str, **values: Any) -> None:
    columns = [sa.column(name, _TYPES.get(name)) for name in values]
    connection.execute(sa.insert(sa.table(table, *columns)).values(values))


def _check(points: float) -> dict[str, Any]:
    """A line of a verdict, as that version wrote it."""
    return {
        "id": "a",
        "title": "Première",
        "passed": points == 20,
        "points": points,
        "max_points": 20,
        "message": "",
        "counterexample": None,
        "hint": None,
        "figure": "a",
    }


class Landed:
    """Who is in it, and the names of what they sent."""

    def __init__(self, engine: Engine) -> None:
        self.ada, self.guest, self.teacher, self.busy = (uuid4() for _ in range(4))
        self.lease = uuid4()
        self.sent: dict[str, UUID] = {}
        self._clock = NOON
        upgrade(engine, BEFORE)
        with writing_engine(engine).begin() as self._connection:
            self._people()
            self._attempts()
            self._what_was_given()

    def _people(self) -> None:
        for account_id, role, name in (
            (self.ada, "student", "Ada"),
            (self.guest, "guest", "Guest"),
            (self.teacher, "teacher", "Mme Martin"),
            (self.busy, "student", "Bob"),
        ):
            self._add("account", id=account_id, role=role, name=name)
            token = {"token_digest": sha256_hex(name), "account_id": account_id}
            self._add("browser_session", **token, expires_at=LATER)
            self._add("api_token", **token, id=uuid4(), label="essai")

    def _attempts(self) -> None:
        self._graded("wrong", self.ada, Outcome.WRONG_ANSWER, 10, NAMED)
        self._graded("right", self.ada, Outcome.OK, 20)
        self._graded("late", self.ada, Outcome.TIMEOUT, 5)
        self._graded("ours", self.ada, Outcome.INTERNAL_ERROR, 0)
        self._graded("answers", self.ada, Outcome.WRONG_ANSWER, 8, exercise=ANSWERS, timings={"total_ms": 2.5})
        self._graded("visitor", self.guest, Outcome.WRONG_ANSWER, 15)
        for number in range(MANY):
            self._graded(f"busy {number}", self.busy, Outcome.WRONG_ANSWER, number % 20)
        self._submission("queued", self.ada, state="queued", attempts=1, started_at=self._clock)
        leased = {"lease_owner": OWNER, "lease_token": self.lease, "lease_until": LATER}
        self._submission("running", self.ada, state="running", attempts=2, started_at=self._clock, **leased)

    def _what_was_given(self) -> None:
        self._add("draw", account_id=self.ada, exercise=ANSWERS, seed=77)
        self._add("draw", account_id=self.guest, exercise=ANSWERS, seed=78)
        _insert(self._connection, "solution_opening", exercise=POSES, opened_by=self.teacher, opened_at=NOON)

    def _graded(
        self,
        name: str,
        account_id: UUID,
        outcome: Outcome,
        points: float,
        diagnosis: dict[str, str] | None = None,
        *,
        exercise: str = POSES,
        timings: dict[str, float] | None = None,
    ) -> None:
        ours = outcome is Outcome.INTERNAL_ERROR
        measured = {"checks_ms": 1.5, "diagnosis_ms": 0.5, "total_ms": 2.0} if timings is None else timings
        verdict = {
            "exercise": exercise,
            "exercise_version": "abc123",
            "outcome": outcome.value,
            "score": points / 20,
            "points": points,
            "max_points": 20,
            "checks": [] if ours else [_check(points)],
            "diagnosis": diagnosis,
            "stdout": "",
            "seed": 7,
            "timings": {} if ours else measured,
        }
        self._submission(
            name,
            account_id,
            exercise=exercise,
            state="done",
            attempts=1,
            started_at=self._clock + timedelta(minutes=2),
            finished_at=self._clock + timedelta(minutes=3),
            outcome=outcome.value,
            score=None if ours else points / 20,
            verdict=verdict,
            figures={} if ours else {"a": {"kind": "fake", "name": name}},
        )

    def _submission(self, name: str, account_id: UUID, exercise: str = POSES, **values: Any) -> None:
        self.sent[name] = uuid4()
        source = b'{"ds":1}' if exercise == ANSWERS else f"# {name}\n".encode()
        fixed = {"id": self.sent[name], "account_id": account_id, "exercise": exercise, "source": source}
        self._add("submission", **fixed, digest=name, seed=7, **values)

    def _add(self, table: str, **values: Any) -> None:
        self._clock += timedelta(minutes=1)
        _insert(self._connection, table, **values, created_at=self._clock)
