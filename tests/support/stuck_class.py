"""Simulated lessons, in which it is known who is stuck: each student has a hidden state that no rule reads.

A student solves exercises in a few steps. While a step is understood, each attempt makes it with some probability. A
step that is not understood is not made for 12 to 45 minutes: the student is stuck on it, and hammers on, falls silent
in front of the screen, or goes on at half the pace. Slow students think long and understand; others are absent,
or leave. The history of two earlier lessons gives each student a pace of their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from random import Random
from uuid import UUID

from graders.core.contract.outcomes import Outcome
from server.gradebook.histories import AttemptsByPair, GradedAttempt

START = datetime(2026, 11, 23, 9, 0, tzinfo=UTC)
LESSON_MINUTES = 90.0
EXERCISES = ("l20/a", "l20/b", "l20/c", "l20/d")
#: Minutes after which a student who does not understand a step is known to be stuck: until then nobody can tell.
STUCK_AFTER = 8.0
PRESENCE_RECORD = 5.0
STUCK_PROBABILITY = 0.08  # at a step, of a student of little skill


@dataclass
class Pupil:
    """A student with a hidden state; times in minutes from the start of the lesson."""

    account: UUID
    pace: float
    skill: float
    kind: str
    attempts: dict[str, list[GradedAttempt]] = field(default_factory=dict)
    visits: list[float] = field(default_factory=list)
    stuck: list[tuple[float, float]] = field(default_factory=list)
    leaves_at: float = LESSON_MINUTES
    has_finished: bool = False


@dataclass(frozen=True)
class SimulatedClass:
    pupils: tuple[Pupil, ...]

    def attempts_at(self, minute: float) -> AttemptsByPair:
        """Return what has been sent by that minute, as the board reads it."""
        until = START + timedelta(minutes=minute)
        pairs = {
            (pupil.account, exercise): tuple(attempt for attempt in series if attempt.sent_at <= until)
            for pupil in self.pupils
            for exercise, series in pupil.attempts.items()
        }
        return {pair: series for pair, series in pairs.items() if series}

    def seen_at(self, minute: float) -> dict[UUID, datetime | None]:
        """Return when each student was last recorded as present: every five minutes at most."""
        seen: dict[UUID, datetime | None] = {}
        for pupil in self.pupils:
            recorded: float | None = None
            for visit in sorted(pupil.visits):
                if visit <= minute and (recorded is None or visit - recorded >= PRESENCE_RECORD):
                    recorded = visit
            seen[pupil.account] = None if recorded is None else START + timedelta(minutes=recorded)
        return seen

    def stuck(self, minute: float, after: float = STUCK_AFTER) -> frozenset[UUID]:
        """Return who has been stuck for that many minutes, and is there."""
        return frozenset(
            pupil.account
            for pupil in self.pupils
            if minute < pupil.leaves_at and any(begin + after <= minute < end for begin, end in pupil.stuck)
        )


def simulate_class(seed: int, size: int = 35) -> SimulatedClass:
    random = Random(seed)
    return SimulatedClass(tuple(_pupil(random, number) for number in range(size)))


def _pupil(random: Random, number: int) -> Pupil:
    kind = random.choices(("usual", "slow", "absent", "leaves"), (78, 12, 5, 5))[0]
    pace = random.uniform(6.0, 9.0) if kind == "slow" else random.lognormvariate(0.8, 0.4)
    pupil = Pupil(UUID(int=number + 1), pace, random.betavariate(4, 3), kind)
    for week in (2, 1):
        _history(random, pupil, week)
    if kind != "absent":
        _lesson(random, pupil)
    return pupil


def _history(random: Random, pupil: Pupil, week: int) -> None:
    """An earlier lesson: attempts at the student's pace at exercises of its own."""
    at = -week * 7 * 24 * 60.0
    for number in range(random.randint(4, 8)):
        at += _thinking(random, pupil)
        _send(pupil, f"l20/semaine{week}", at, 1.0 if number > 5 else 0.1 * number, None, random.random())


def _thinking(random: Random, pupil: Pupil) -> float:
    return pupil.pace * random.lognormvariate(0.0, 0.45)


def _lesson(random: Random, pupil: Pupil) -> None:
    if pupil.kind == "leaves":
        pupil.leaves_at = random.uniform(15, 60)
    at = random.uniform(1, 8)
    pupil.visits.append(at)
    for exercise in EXERCISES:
        steps, made, at_understood = random.randint(1, 3), 0, None
        mistake = random.choice(("m1", "m2", None))
        while made < steps:
            if random.random() < STUCK_PROBABILITY * (1.1 - pupil.skill):
                at = at_understood = _be_stuck(random, pupil, exercise, at, made / steps)
            at += _thinking(random, pupil)
            if pupil.stuck and pupil.stuck[-1][1] == at_understood:
                pupil.stuck[-1] = (pupil.stuck[-1][0], at)
            if at > min(pupil.leaves_at, LESSON_MINUTES):
                return
            if random.random() < 0.35 + 0.5 * pupil.skill:
                made, mistake = made + 1, random.choice(("m1", "m2", None))
            _send(pupil, exercise, at, made / steps, None if made == steps else mistake, random.random())
        at += random.uniform(1, 3)
        pupil.visits.append(at)
    pupil.has_finished = True


def _be_stuck(random: Random, pupil: Pupil, exercise: str, at: float, score: float) -> float:
    """Be stuck for a while; return when the step is understood at last. The next attempt shows it."""
    end = at + random.uniform(12, 45)
    pupil.stuck.append((at, end))
    pupil.visits.extend(_visits(random, at, min(end, pupil.leaves_at)))
    way = random.choice(("hammers", "is silent", "slows"))
    mistake = random.choice(("m1", "m2", None))
    left = random.randint(1, 2) if way == "is silent" else 100
    while left:
        at += _thinking(random, pupil) * {"hammers": 0.8, "is silent": 1.0, "slows": 2.0}[way]
        if at > min(end, pupil.leaves_at):
            break
        if random.random() < 0.25:
            mistake = random.choice(("m1", "m2", None))
        _send(pupil, exercise, at, score, mistake, random.random())
        left -= 1
    return end


def _visits(random: Random, at: float, end: float) -> Iterator[float]:
    """Reads the lesson, the hints or the statement again now and then."""
    while (at := at + random.expovariate(1 / 6)) < end:
        yield at


def _send(pupil: Pupil, exercise: str, at: float, score: float, diagnosis: str | None, code: float) -> None:
    outcome = Outcome.OK if score >= 1.0 else Outcome.WRONG_ANSWER
    identity = UUID(int=int(code * 2**64))
    sent_at = START + timedelta(minutes=at)
    attempt = GradedAttempt(
        identity, sent_at, score, pupil.account, exercise, str(code), outcome.value, diagnosis, identity
    )
    pupil.attempts.setdefault(exercise, []).append(attempt)
    if at >= 0:
        pupil.visits.append(at)
