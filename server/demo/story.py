"""What the students of the class send, when: drawn from a seed, with the programs that the course knows.

In each of four lessons a student begins its exercises one after the other. Before the right program come wrong ones:
mostly those of a few misconceptions that many share, each kept for an attempt or more before it is overcome.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from random import Random

from graders.core.contract.outcomes import Outcome
from graders.core.contract.protocol import KnownSubmission
from server.course import Exercise, Module
from server.demo.people import Pupil

LESSONS = 4
BETWEEN_LESSONS = timedelta(days=7)
LASTING = timedelta(minutes=90)
SINCE = timedelta(minutes=35)  # how long the last lesson has gone on
ABSENT = 0.06
KEPT = 0.45  # a misconception is kept for one more attempt
OTHER = 0.25  # a mistake that has no name: of syntax, of form, or an odd one
POPULAR = 1.8  # misconceptions that most of the named mistakes of an exercise are
SEEN = (0.1, 0.55)  # how soon the right program is found: for whom all is hard, and what ease adds
LEFT = 0.16  # an exercise is left unsolved after an attempt, by whom all is hard
UNNAMED = (Outcome.WRONG_ANSWER, Outcome.RUNTIME_ERROR, Outcome.SYNTAX_ERROR, Outcome.INVALID_OUTPUT)


@dataclass(frozen=True)
class Repertoire:
    """What one may send to an exercise, by its place in what is known of it (`Exercise.grader.known`)."""

    right: tuple[KnownSubmission, ...]
    named: tuple[tuple[KnownSubmission, ...], ...]
    unnamed: tuple[KnownSubmission, ...]


@dataclass(frozen=True)
class Step:
    """An attempt: who sends what, when. `again`: how often the same student had sent the same program before."""

    pupil: int
    exercise: str
    known: KnownSubmission
    sent_at: datetime
    again: int


def lesson_starts(now: datetime) -> tuple[datetime, ...]:
    """When the lessons began: the last is going on."""
    return tuple(now - SINCE - BETWEEN_LESSONS * weeks for weeks in reversed(range(LESSONS)))


def programme(module: Module) -> tuple[tuple[Exercise, ...], ...]:
    """The module's exercises in the order in which one meets them, shared among the lessons."""
    places = {lesson.slug: place for place, lesson in enumerate(module.lessons)}
    met = sorted(module.exercises, key=lambda exercise: places.get(exercise.seance, len(places)))
    count = len(met)
    cuts = [count * lesson // LESSONS for lesson in range(LESSONS + 1)]
    return tuple(tuple(met[start:end]) for start, end in itertools.pairwise(cuts))


def repertoire(exercise: Exercise, random: Random) -> Repertoire:
    """The misconceptions in an order of their own: the first are those that many have."""
    known = list(exercise.grader.known_submissions())
    named: dict[str, list[KnownSubmission]] = {}
    for one in known:
        if one.diagnosis is not None:
            named.setdefault(one.diagnosis, []).append(one)
    order = sorted(named)
    random.shuffle(order)
    unnamed = [one for one in known if one.diagnosis is None and one.outcome in UNNAMED and _is_honest(one)]
    return Repertoire(
        right=tuple(one for one in known if one.outcome is Outcome.OK),
        named=tuple(tuple(named[name]) for name in order),
        unnamed=tuple(sorted(unnamed, key=lambda one: UNNAMED.index(one.outcome))),
    )


def _is_honest(known: KnownSubmission) -> bool:
    """Not a program that plays tricks on its grader, which nobody of the class would write."""
    return b"__" not in known.source_for_seed(0)


def story(module: Module, pupils: Sequence[Pupil], random: Random, now: datetime) -> list[Step]:
    """Everything that is sent in the four lessons, in time; what the last still brings lies after `now`."""
    repertoires = {exercise.id: repertoire(exercise, random) for exercise in module.exercises}
    steps = [
        step
        for start, exercises in zip(lesson_starts(now), programme(module), strict=True)
        for number, pupil in enumerate(pupils)
        if random.random() >= ABSENT
        for step in _lesson(number, pupil, exercises, repertoires, random, start)
    ]
    return sorted(steps, key=lambda step: step.sent_at)


def _lesson(
    number: int,
    pupil: Pupil,
    exercises: Sequence[Exercise],
    repertoires: Mapping[str, Repertoire],
    random: Random,
    start: datetime,
) -> Iterator[Step]:
    at, end = start + timedelta(minutes=random.uniform(2, 9)), start + LASTING
    for exercise in exercises:
        sent: dict[int, int] = {}
        for known in _attempts(repertoires[exercise.id], pupil.ease, random):
            at += timedelta(minutes=pupil.pace * random.uniform(0.5, 1.8))
            if at > end:
                return
            yield Step(number, exercise.id, known, at, sent.get(id(known), 0))
            sent[id(known)] = sent.get(id(known), 0) + 1
        at += timedelta(minutes=random.uniform(1, 4))  # reads the next


def _attempts(of: Repertoire, ease: float, random: Random) -> Iterator[KnownSubmission]:
    """Wrong ones while the exercise is not understood, then the right one; who finds it hard may leave it."""
    while random.random() > SEEN[0] + SEEN[1] * ease:
        if of.unnamed and (not of.named or random.random() < OTHER):
            yield of.unnamed[min(int(random.expovariate(1.0)), len(of.unnamed) - 1)]
        elif of.named:
            popular = of.named[min(int(random.expovariate(1 / POPULAR)), len(of.named) - 1)]
            yield random.choice(popular)
            while random.random() < KEPT:
                yield random.choice(popular)
        if random.random() < LEFT * (1 - ease):
            return
    yield random.choice(of.right)
