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

LESSON_COUNT = 4
BETWEEN_LESSONS = timedelta(days=7)
LESSON_DURATION = timedelta(minutes=90)
ELAPSED = timedelta(minutes=35)  # how long the last lesson has gone on
ABSENCE_PROBABILITY = 0.06
REPEAT_PROBABILITY = 0.45  # a misconception is kept for one more attempt
UNNAMED_PROBABILITY = 0.25  # a mistake that has no name: of syntax, of form, or an odd one
POPULARITY_SCALE = 1.8  # misconceptions that most of the named mistakes of an exercise are
SUCCESS_PROBABILITY = (0.1, 0.55)  # how soon the right program is found: for whom all is hard, and what ease adds
GIVE_UP_PROBABILITY = 0.16  # an exercise is left unsolved after an attempt, by whom all is hard
UNNAMED = (Outcome.WRONG_ANSWER, Outcome.RUNTIME_ERROR, Outcome.SYNTAX_ERROR, Outcome.INVALID_OUTPUT)


@dataclass(frozen=True)
class Repertoire:
    """What one may send to an exercise, by its place in what is known of it (`Exercise.grader.known`)."""

    right: tuple[KnownSubmission, ...]
    named: tuple[tuple[KnownSubmission, ...], ...]
    unnamed: tuple[KnownSubmission, ...]


@dataclass(frozen=True)
class PlannedAttempt:
    """An attempt: who sends what, when. `again`: how often the same student had sent the same program before."""

    pupil: int
    exercise: str
    submission: KnownSubmission
    sent_at: datetime
    repeats: int


def lesson_starts(now: datetime) -> tuple[datetime, ...]:
    """When the lessons began: the last is going on."""
    return tuple(now - ELAPSED - BETWEEN_LESSONS * weeks for weeks in reversed(range(LESSON_COUNT)))


def exercises_by_lesson(module: Module) -> tuple[tuple[Exercise, ...], ...]:
    """The module's exercises in the order in which one meets them, shared among the lessons."""
    places = {lesson.slug: place for place, lesson in enumerate(module.lessons)}
    met = sorted(module.exercises, key=lambda exercise: places.get(exercise.seance, len(places)))
    count = len(met)
    cuts = [count * lesson // LESSON_COUNT for lesson in range(LESSON_COUNT + 1)]
    return tuple(tuple(met[start:end]) for start, end in itertools.pairwise(cuts))


def build_repertoire(exercise: Exercise, random: Random) -> Repertoire:
    """The misconceptions in an order of their own: the first are those that many have."""
    known = list(exercise.grader.known_submissions())
    named: dict[str, list[KnownSubmission]] = {}
    for submission in known:
        if submission.diagnosis is not None:
            named.setdefault(submission.diagnosis, []).append(submission)
    order = sorted(named)
    random.shuffle(order)
    unnamed = [
        submission
        for submission in known
        if submission.diagnosis is None and submission.outcome in UNNAMED and _is_honest(submission)
    ]
    return Repertoire(
        right=tuple(submission for submission in known if submission.outcome is Outcome.OK),
        named=tuple(tuple(named[name]) for name in order),
        unnamed=tuple(sorted(unnamed, key=lambda submission: UNNAMED.index(submission.outcome))),
    )


def _is_honest(known: KnownSubmission) -> bool:
    """Not a program that plays tricks on its grader, which nobody of the class would write."""
    return b"__" not in known.source_for_seed(0)


def plan_attempts(module: Module, pupils: Sequence[Pupil], random: Random, now: datetime) -> list[PlannedAttempt]:
    """Everything that is sent in the four lessons, in time; what the last still brings lies after `now`."""
    repertoires = {exercise.id: build_repertoire(exercise, random) for exercise in module.exercises}
    steps = [
        step
        for start, exercises in zip(lesson_starts(now), exercises_by_lesson(module), strict=True)
        for number, pupil in enumerate(pupils)
        if random.random() >= ABSENCE_PROBABILITY
        for step in _pupil_attempts(number, pupil, exercises, repertoires, random, start)
    ]
    return sorted(steps, key=lambda step: step.sent_at)


def _pupil_attempts(
    number: int,
    pupil: Pupil,
    exercises: Sequence[Exercise],
    repertoires: Mapping[str, Repertoire],
    random: Random,
    start: datetime,
) -> Iterator[PlannedAttempt]:
    at, end = start + timedelta(minutes=random.uniform(2, 9)), start + LESSON_DURATION
    for exercise in exercises:
        sent: dict[int, int] = {}
        for known in _draw_submissions(repertoires[exercise.id], pupil.ease, random):
            at += timedelta(minutes=pupil.pace * random.uniform(0.5, 1.8))
            if at > end:
                return
            yield PlannedAttempt(number, exercise.id, known, at, sent.get(id(known), 0))
            sent[id(known)] = sent.get(id(known), 0) + 1
        at += timedelta(minutes=random.uniform(1, 4))  # reads the next


def _draw_submissions(of: Repertoire, ease: float, random: Random) -> Iterator[KnownSubmission]:
    """Wrong ones while the exercise is not understood, then the right one; who finds it hard may leave it."""
    while random.random() > SUCCESS_PROBABILITY[0] + SUCCESS_PROBABILITY[1] * ease:
        if of.unnamed and (not of.named or random.random() < UNNAMED_PROBABILITY):
            yield of.unnamed[min(int(random.expovariate(1.0)), len(of.unnamed) - 1)]
        elif of.named:
            popular = of.named[min(int(random.expovariate(1 / POPULARITY_SCALE)), len(of.named) - 1)]
            yield random.choice(popular)
            while random.random() < REPEAT_PROBABILITY:
                yield random.choice(popular)
        if random.random() < GIVE_UP_PROBABILITY * (1 - ease):
            return
    yield random.choice(of.right)
