"""A class that has worked: students, and attempts whose verdicts are stored without any grader having run."""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import groupby
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import insert, update

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import Database, table_of
from server.gradebook.models import Grading, Standing
from server.gradebook.standings import CountedAttempt, compute_standing_totals
from server.identity.models import Account, Role
from server.submissions.models import Submission
from server.submissions.service import digest_code

GROUPS = ("TP1", "TP2")
GIVEN = ("Ada", "Alan", "Grace", "Edsger", "Emmy", "Blaise", "Sophie", "Évariste", "Kurt", "Hypatie")
FAMILY = ("Lovelace", "Turing", "Hopper", "Dijkstra", "Noether", "Pascal", "Germain", "Galois", "Gödel", "d’Alexandrie")


@dataclass(frozen=True)
class Sent:
    """One attempt to be stored; `score` in [0, 1], None for an error of ours; `checks`: those of its verdict."""

    account: UUID
    exercise: str
    at: datetime
    score: float | None
    diagnosis: str | None = None
    code: str = "x = 1\n"
    outcome: Outcome = Outcome.WRONG_ANSWER
    checks: tuple[CheckResult, ...] = ()

    @property
    def ended(self) -> Outcome:
        if self.score is None:
            return Outcome.INTERNAL_ERROR
        return Outcome.OK if self.score == 1.0 else self.outcome


def verdict_of(sent: Sent, padding: int = 0) -> Verdict:
    """Of the size of a real one with `padding` characters."""
    score = sent.score or 0.0
    only = CheckResult("a", "Première", score == 1.0, 20 * score, 20.0, "." * padding)
    checks = sent.checks or ([] if sent.score is None else [only])
    diagnosis = Diagnosis(sent.diagnosis, sent.diagnosis, "") if sent.diagnosis else None
    return Verdict(sent.exercise, "v1", sent.ended, 1, checks, diagnosis)


def store(database: Database, attempts: Collection[Sent], padding: int = 0) -> Sequence[UUID]:
    """Stores attempts as if each had been graded when it was sent, with the standings that they come to: all of a
    student's attempts at an exercise at once."""
    ordered = sorted(attempts, key=lambda one: (str(one.account), one.exercise, one.at))
    rows = [_rows(one, padding) for one in ordered]
    with database.write() as db:
        for submission, _ in rows:
            submission["grading_id"] = None
        db.execute(insert(table_of(Submission)), [submission for submission, _ in rows])
        db.execute(insert(table_of(Grading)), [grading for _, grading in rows])
        table = table_of(Submission)
        db.execute(update(table).values(grading_id=_grading_of(table)).where(table.c.grading_id.is_(None)))
        for account, exercise, attempts_there in _by_pair(ordered):
            counted = [
                CountedAttempt(one.at, one.ended.value, one.score, one.diagnosis)
                for one in attempts_there
                if one.score is not None
            ]
            if counted:
                db.merge(Standing(account_id=account, exercise=exercise, **vars(compute_standing_totals(counted))))
    return [submission["id"] for submission, _ in rows]


def _grading_of(table: Any) -> Any:
    gradings = table_of(Grading)
    return (
        gradings.select()
        .with_only_columns(gradings.c.id)
        .where(gradings.c.submission_id == table.c.id)
        .scalar_subquery()
    )


def _by_pair(ordered: Sequence[Sent]) -> Iterator[tuple[UUID, str, list[Sent]]]:
    for (_, exercise), sent in groupby(ordered, key=lambda one: (str(one.account), one.exercise)):
        attempts = list(sent)
        yield attempts[0].account, exercise, attempts


def _rows(sent: Sent, padding: int) -> tuple[dict[str, Any], dict[str, Any]]:
    identity = uuid4()
    submission = {
        "id": identity, "account_id": sent.account, "exercise": sent.exercise, "source": sent.code.encode(),
        "digest": digest_code(sent.code), "seed": 1, "created_at": sent.at,
    }  # fmt: skip
    grading = {
        "id": uuid4(), "submission_id": identity, "exercise_version": "v1", "outcome": sent.ended.value,
        "score": sent.score, "diagnosis": sent.diagnosis, "seed": 1, "started_at": sent.at, "finished_at": sent.at,
        "verdict": verdict_of(sent, padding).to_json(), "figures": {},
    }  # fmt: skip
    return submission, grading


def seated(database: Database, made: SchoolClass, count: int, seen_at: datetime | None = None) -> Sequence[UUID]:
    """Has so many new students be in the class, in groups."""
    people = [
        (uuid4(), f"{GIVEN[one % 10]} {FAMILY[one // 10 % 10]}{f' {one // 100}' if one >= 100 else ''}")
        for one in range(count)
    ]
    with database.write() as db:
        db.execute(insert(table_of(Account)), [{"id": one, "role": Role.student, "name": name} for one, name in people])
        rows = [
            {
                "class_id": made.id, "account_id": one, "role": ClassRole.student, "status": Status.active,
                "groups": [GROUPS[place % 2]], "last_seen_at": seen_at,
            }
            for place, (one, _) in enumerate(people)
        ]  # fmt: skip
        db.execute(insert(table_of(Membership)), rows)
    return [one for one, _ in people]


def lessons(
    students: Sequence[UUID],
    exercises: Sequence[str],
    mistakes: Mapping[str, Sequence[str]],
    now: datetime,
    seed: int = 1,
) -> list[Sent]:
    """What students of unequal skill send over some weeks, the last of it just before `now`. The same for a seed.

    `mistakes`: ids of misconceptions, by exercise.
    """
    draw = random.Random(seed)
    attempts: list[Sent] = []
    for student in students:
        skill = draw.random()
        done = max(1, round(len(exercises) * (0.3 + 0.6 * skill)))
        for place, exercise in enumerate(exercises[:done]):
            begun = now - timedelta(days=7 * (done - 1 - place) / 4, minutes=draw.uniform(1, 50))
            attempts += _one_exercise(draw, student, exercise, skill, mistakes.get(exercise, ()), begun)
    return [one for one in attempts if one.at <= now]


def _one_exercise(
    draw: random.Random, student: UUID, exercise: str, skill: float, mistakes: Sequence[str], begun: datetime
) -> Iterator[Sent]:
    at, score, mistake = begun, 0.0, draw.choice(mistakes) if mistakes and draw.random() < 0.7 else None
    for number in range(draw.randint(1, 7)):
        right = draw.random() < 0.15 + 0.5 * skill
        score = 1.0 if right else min(0.95, round(score + draw.choice((0.0, 0.0, 0.15, 0.3)), 2))
        code = f"def composer(a, b):\n    return a + {number}\n"
        yield Sent(student, exercise, at, score, None if right else mistake, code)
        if right:
            return
        at += timedelta(minutes=draw.uniform(0.5, 6))
        if draw.random() < 0.35:
            mistake = draw.choice([*mistakes, None]) if mistakes else None
