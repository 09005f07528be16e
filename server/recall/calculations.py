"""Small calculations and choices about a misconception: one question of its exercise, with fresh numbers or letters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date

from sqlalchemy.orm import Session

from graders.core.answers import Question
from graders.core.answers.choice import ChoiceGrader
from graders.core.answers.numeric import NumericGrader
from graders.core.answers.question_paper import GivenDatum
from graders.core.answers.retrieval import make_seed
from graders.core.compare.words import number
from graders.core.contract.outcomes import Outcome
from server.assignments import feedback
from server.base.errors import Conflict, Invalid, NotFound
from server.course import Course, Exercise
from server.identity.models import Account
from server.recall import repository
from server.recall.models import QuestionKind, RecallAnswer
from server.recall.retrievals import NO_QUESTION, require_today_or_yesterday
from server.recall.subjects import subject_of_misconception

IN_TEST = "Cette question attend les résultats du contrôle « {title} »."
EMPTY = "Donnez une réponse."


@dataclass(frozen=True)
class AskedCalculation:
    """A question about a misconception with its numbers of a day; `given` are the data that it may use."""

    exercise: Exercise
    misconception: str
    day: date
    seed: int
    question: Question
    given: Sequence[GivenDatum]


@dataclass(frozen=True)
class CalculationMark:
    """Whether an answer is right, the words that say why, in Markdown, and the right answer in words."""

    is_right: bool
    message: str
    right: str


def has_calculation_questions(exercise: Exercise) -> bool:
    """Whether an exercise has questions of numbers or choices that may be asked again."""
    return exercise.hunts != "never" and isinstance(exercise.answers, NumericGrader | ChoiceGrader)


def find_question_showing_misconception(exercise: Exercise, misconception: str) -> str | None:
    """Return the first question of an exercise in which a misconception shows: it depends on the fewest others."""
    grader = exercise.answers
    if isinstance(grader, NumericGrader):
        return next((quantity.id for quantity in grader.quantities if misconception in quantity.slips), None)
    if isinstance(grader, ChoiceGrader):
        shown = ((question.id, {option.misconception for option in question.options}) for question in grader.questions)
        return next((name for name, misconceptions in shown if misconception in misconceptions), None)
    return None


def draw_calculation(
    course: Course, exercise_id: str, misconception: str, account: Account, day: date
) -> AskedCalculation:
    """Draw the question about a misconception for an account and a day. Raises NotFound."""
    exercise = course.exercises.get(exercise_id)
    name = (
        None
        if exercise is None or not has_calculation_questions(exercise)
        else find_question_showing_misconception(exercise, misconception)
    )
    if exercise is None or exercise.answers is None or name is None:
        raise NotFound(NO_QUESTION)
    seed = make_seed("calculation", str(account.id), exercise_id, misconception, day.isoformat())
    paper = exercise.answers.paper(seed)
    question = next(question for question in paper.questions if question.id == name)
    return AskedCalculation(exercise, misconception, day, seed, question, paper.given)


def mark_calculation(asked: AskedCalculation, typed: Sequence[str]) -> CalculationMark:
    """Judge a typed number or the letters of options as in the exercise. Raises Invalid for what is no answer."""
    grader, question = asked.exercise.answers, asked.question
    assert grader is not None
    values = [value for value in typed if value.strip()]
    if not values:
        raise Invalid(EMPTY)
    findings = grader.judge({question.id: values if question.form == "several" else values[0]}, asked.seed)
    finding = next(finding for finding in findings if finding.result.id == question.id)
    if finding.cause is Outcome.INVALID_OUTPUT:
        raise Invalid(finding.result.message)
    return CalculationMark(finding.passed, finding.result.message, _right_answer_text(asked))


def _right_answer_text(asked: AskedCalculation) -> str:
    grader, question = asked.exercise.answers, asked.question
    assert grader is not None
    right = grader.right_answers(asked.seed)[question.id]
    if question.form == "number":
        return f"{number(float(right), 4)} {question.unit}".rstrip()
    return " et ".join(right) if isinstance(right, list) else str(right)


def submit_calculation(
    db: Session, course: Course, account: Account, asked: AskedCalculation, typed: Sequence[str]
) -> CalculationMark:
    """Mark an answer to a question of today or yesterday, and store it.

    Raises Conflict for another day and during a test that asks the exercise, Invalid for what is no answer.
    """
    require_today_or_yesterday(asked.day)
    if tests := feedback.load_holds(db, account.id, asked.exercise.id).tests:
        raise Conflict(IN_TEST.format(title=tests[0].title))
    marked = mark_calculation(asked, typed)
    repository.add_answer(db, RecallAnswer(
        account_id=account.id, subject=subject_of_misconception(course, asked.exercise, asked.misconception),
        kind=QuestionKind.calculation, exercise=asked.exercise.id, misconception=asked.misconception,
        is_right=marked.is_right,
    ))  # fmt: skip
    return marked
