"""What the students of the class send, when: drawn from a seed, with the programs that the course knows.

In each of four lessons a student begins its exercises one after the other. Before the right program come wrong ones:
mostly those of a few misconceptions that many share, each kept for an attempt or more before it is overcome. Between
two lessons some go on at home with what they left wrong, and mostly make the same mistake again.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from random import Random

from graders.core.contract.outcomes import Outcome
from graders.core.contract.protocol import KnownSubmission
from server.course import Exercise, Module
from server.demo.people import SimulatedStudent

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
HOMEWORK_PROBABILITY, HOMEWORK_DAYS = 0.4, 2  # who left an exercise wrong goes on at home, and on how many days
RELAPSE_PROBABILITY = 0.6  # a day at home brings the same mistake again instead of the right program
UNNAMED = (Outcome.WRONG_ANSWER, Outcome.RUNTIME_ERROR, Outcome.SYNTAX_ERROR, Outcome.INVALID_OUTPUT)


@dataclass(frozen=True)
class SubmissionRepertoire:
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


def lesson_start_times(now: datetime) -> tuple[datetime, ...]:
    """When the lessons began: the last is going on."""
    return tuple(now - ELAPSED - BETWEEN_LESSONS * weeks for weeks in reversed(range(LESSON_COUNT)))


def divide_exercises_evenly(module: Module) -> tuple[tuple[Exercise, ...], ...]:
    """The module's exercises in the order in which one meets them, shared among the lessons."""
    places = {lesson.slug: place for place, lesson in enumerate(module.lessons)}
    met = sorted(module.exercises, key=lambda exercise: places.get(exercise.seance, len(places)))
    count = len(met)
    cuts = [count * lesson // LESSON_COUNT for lesson in range(LESSON_COUNT + 1)]
    return tuple(tuple(met[start:end]) for start, end in itertools.pairwise(cuts))


def build_submission_repertoire(exercise: Exercise, random: Random) -> SubmissionRepertoire:
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
        if submission.diagnosis is None and submission.outcome in UNNAMED and _is_honest_submission(submission)
    ]
    return SubmissionRepertoire(
        right=tuple(submission for submission in known if submission.outcome is Outcome.OK),
        named=tuple(tuple(named[name]) for name in order),
        unnamed=tuple(sorted(unnamed, key=lambda submission: UNNAMED.index(submission.outcome))),
    )


def _is_honest_submission(known: KnownSubmission) -> bool:
    """Not a program that plays tricks on its grader, which nobody of the class would write."""
    return b"__" not in known.source_for_seed(0)


def plan_attempts(
    module: Module, pupils: Sequence[SimulatedStudent], random: Random, now: datetime
) -> list[PlannedAttempt]:
    """Everything that is sent in the four lessons and between them, in time; what the last still brings lies after
    `now`."""
    repertoires = {exercise.id: build_submission_repertoire(exercise, random) for exercise in module.exercises}
    steps = [
        step
        for start, exercises in zip(lesson_start_times(now), divide_exercises_evenly(module), strict=True)
        for number, pupil in enumerate(pupils)
        if random.random() >= ABSENCE_PROBABILITY
        for step in _plan_attempts_in_lesson(number, pupil, exercises, repertoires, random, start)
    ]
    steps += [
        step
        for start in lesson_start_times(now)[:-1]
        for step in _plan_homework_attempts(steps, start, repertoires, random)
    ]
    return sorted(steps, key=lambda step: step.sent_at)


def _plan_homework_attempts(
    steps: Sequence[PlannedAttempt], start: datetime, repertoires: Mapping[str, SubmissionRepertoire], random: Random
) -> Iterator[PlannedAttempt]:
    """Some of those who left an exercise of the lesson wrong, on some of the days before the next one."""
    sent: dict[tuple[int, str], list[PlannedAttempt]] = {}
    for step in steps:
        if start <= step.sent_at <= start + LESSON_DURATION:
            sent.setdefault((step.pupil, step.exercise), []).append(step)
    left = {pupil: own for (pupil, _), own in sent.items() if own[-1].submission.outcome is not Outcome.OK}
    days = range(1, BETWEEN_LESSONS.days - 1)
    for own in left.values():
        if len(days) >= HOMEWORK_DAYS and random.random() < HOMEWORK_PROBABILITY:
            chosen = sorted(random.sample(days, HOMEWORK_DAYS))
            yield from _plan_attempts_at_home(own, [start + timedelta(days=day) for day in chosen], repertoires, random)


def _plan_attempts_at_home(
    own: Sequence[PlannedAttempt],
    days: Sequence[datetime],
    repertoires: Mapping[str, SubmissionRepertoire],
    random: Random,
) -> Iterator[PlannedAttempt]:
    """What somebody sends at home on these days to an exercise that they left wrong, until it is right."""
    pupil, exercise, last = own[-1].pupil, own[-1].exercise, own[-1].submission
    of, times = repertoires[exercise], Counter(id(step.submission) for step in own)
    same = next((programs for programs in of.named if programs[0].diagnosis == last.diagnosis), (last,))
    for day in days:
        is_wrong = random.random() < RELAPSE_PROBABILITY
        known = random.choice(same if is_wrong else of.right)
        at = day + timedelta(minutes=random.uniform(0, 120))
        yield PlannedAttempt(pupil, exercise, known, at, times[id(known)])
        times[id(known)] += 1
        if not is_wrong:
            return


def _plan_attempts_in_lesson(
    number: int,
    pupil: SimulatedStudent,
    exercises: Sequence[Exercise],
    repertoires: Mapping[str, SubmissionRepertoire],
    random: Random,
    start: datetime,
) -> Iterator[PlannedAttempt]:
    at, end = start + timedelta(minutes=random.uniform(2, 9)), start + LESSON_DURATION
    for exercise in exercises:
        sent: dict[int, int] = {}
        for known in _draw_submissions(repertoires[exercise.id], pupil.ease, random):
            at += timedelta(minutes=pupil.minutes_between_attempts * random.uniform(0.5, 1.8))
            if at > end:
                return
            yield PlannedAttempt(number, exercise.id, known, at, sent.get(id(known), 0))
            sent[id(known)] = sent.get(id(known), 0) + 1
        at += timedelta(minutes=random.uniform(1, 4))  # reads the next


def _draw_submissions(repertoire: SubmissionRepertoire, ease: float, random: Random) -> Iterator[KnownSubmission]:
    """Wrong ones while the exercise is not understood, then the right one; who finds it hard may leave it."""
    while random.random() > SUCCESS_PROBABILITY[0] + SUCCESS_PROBABILITY[1] * ease:
        if repertoire.unnamed and (not repertoire.named or random.random() < UNNAMED_PROBABILITY):
            yield repertoire.unnamed[min(int(random.expovariate(1.0)), len(repertoire.unnamed) - 1)]
        elif repertoire.named:
            popular = repertoire.named[min(int(random.expovariate(1 / POPULARITY_SCALE)), len(repertoire.named) - 1)]
            yield random.choice(popular)
            while random.random() < REPEAT_PROBABILITY:
                yield random.choice(popular)
        if random.random() < GIVE_UP_PROBABILITY * (1 - ease):
            return
    yield random.choice(repertoire.right)
