"""The questions of a module's lessons, and what is said to them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from functools import lru_cache
from uuid import UUID

from markupsafe import Markup, escape
from sqlalchemy.orm import Session

from graders.core.answers.choice import ChoiceGrader, ChoiceQuestion
from graders.scene.prediction import Placed, Prediction
from graders.typography import french
from server.assignments import feedback
from server.base.errors import Conflict, Invalid, NotFound, Unauthorised
from server.course.code import import_file
from server.course.models import Exercise, Lesson, Module
from server.identity.models import Account
from server.polls import repository
from server.polls.schemas import AnswerCount, MarkedAnswer, Poll, PollOption

#: Of the letters, hence of the order of the options: the same for all who read.
SHUFFLE_SEED = 20
NO_QUESTION = "Cette question n’existe pas."


@lru_cache(maxsize=32)
def polls_of_module(module: Module) -> Mapping[str, Poll]:
    """Every question of a module, by name, in the order of the lessons."""
    return {name: poll for lesson in module.lessons for name, poll in polls_of_lesson(module, lesson).items()}


@lru_cache(maxsize=1024)
def polls_of_lesson(module: Module, lesson: Lesson) -> Mapping[str, Poll]:
    """Return the questions of one lesson, by name."""
    return {poll.name: poll for poll in _iter_lesson_polls(module, lesson)}


def _iter_lesson_polls(module: Module, lesson: Lesson) -> Iterator[Poll]:
    for name in lesson.replays:
        source = import_file(lesson.text.source.path.parents[1] / "rejeux" / f"{name.replace('-', '_')}.py")
        prediction: Prediction | Placed | None = getattr(source, "PREDICTION", None)
        if prediction is not None:
            yield _build_prediction_poll(lesson, name, source.TITLE, prediction)
    for name in lesson.questions:
        found = _find_choice_question(module, name)
        if found is not None:
            yield _build_choice_poll(lesson, name, *found)


def _build_prediction_poll(lesson: Lesson, name: str, title: str, asked: Prediction | Placed) -> Poll:
    options = tuple(
        PollOption(answer_id, escape(french(words)), answer_id == asked.right) for answer_id, words in asked.answers
    )
    href = f"/{lesson.module}/lire/{lesson.slug}#rejeu-{name}"
    place = asked if isinstance(asked, Placed) else None
    return Poll(f"rejeux/{name}", french(title), href, escape(french(asked.question)), options, True, place=place)


def _build_choice_poll(lesson: Lesson, name: str, exercise: Exercise, question: ChoiceQuestion) -> Poll:
    """Build the poll of a choice question, its options shuffled."""
    order = [question.find_option(option_id) for option_id in question.letters(SHUFFLE_SEED).by_letter.values()]
    options = tuple(PollOption(option.id, Markup(exercise.render_line(option.text)), option.right) for option in order)
    href = f"/{lesson.module}/lire/{lesson.slug}#question-{name.replace('/', '-')}"
    asked = Markup(exercise.render_line(question.text))
    return Poll(name, french(question.title), href, asked, options, is_prediction=False, several=question.several)


def _find_choice_question(module: Module, name: str) -> tuple[Exercise, ChoiceQuestion] | None:
    """The question of an exercise, `slug/question`; None where it is no longer there."""
    slug, _, identity = name.partition("/")
    for exercise in module.exercises:
        if exercise.slug == slug and isinstance(exercise.answers, ChoiceGrader):
            return next(
                ((exercise, question) for question in exercise.answers.questions if question.id == identity), None
            )
    return None


def find_poll(module: Module, name: str) -> Poll:
    """Raises NotFound."""
    poll = polls_of_module(module).get(name)
    if poll is None:
        raise NotFound(NO_QUESTION)
    return poll


def submit_poll_answer(db: Session, account: Account | None, module: Module, poll: Poll, answer: str) -> MarkedAnswer:
    """Keeps an answer, of who has an account; of what one expects of a replay, the first alone. Marks it, but for that.

    Raises Invalid; Unauthorised for what a visitor expects, which their browser keeps; Conflict where a test asks it.
    """
    ids = poll.options_counted_for(answer)
    if not ids:
        raise Invalid("Cette réponse n’est pas de celles que la question propose.")
    if account is None and poll.is_prediction:
        raise Unauthorised("Sans compte, votre navigateur garde ce que vous répondez.")
    marked = MarkedAnswer("") if poll.is_prediction else _mark_choice_answer(db, account, module, poll, ids)
    if account is None:
        return marked
    name = f"{module.slug}/{poll.name}"
    (repository.save_first_answer if poll.is_prediction else repository.save_latest_answer)(
        db, account.id, name, answer
    )
    return replace(marked, first=repository.load_first_answers(db, account.id, [name])[name])


def _mark_choice_answer(
    db: Session, account: Account | None, module: Module, poll: Poll, ids: Set[str]
) -> MarkedAnswer:
    """Mark an answer with the grader of the question's exercise."""
    found = _find_choice_question(module, poll.name)
    if found is None:
        raise NotFound(NO_QUESTION)
    exercise, question = found
    if account is not None and feedback.load_holds(db, account.id, exercise.id).tests:
        raise Conflict("Cette question est d’un contrôle : sa réponse vous sera dite quand il sera rendu.")
    assert isinstance(exercise.answers, ChoiceGrader)
    letters = sorted(question.letters(SHUFFLE_SEED).by_name[option_id] for option_id in ids)
    written = letters if question.several else letters[0]
    findings = exercise.answers.judge({question.id: written}, SHUFFLE_SEED)
    result = next(finding.result for finding in findings if finding.result.id == question.id)
    return MarkedAnswer("", result.passed, exercise.render_paragraphs(result.message))


def load_first_answers_in_lesson(
    db: Session, account: Account | None, module: Module, lesson: Lesson
) -> Mapping[str, str]:
    """What somebody said first to the questions of a lesson, by name. Nothing of a visitor: their browser keeps it."""
    names = [f"{module.slug}/{name}" for name in polls_of_lesson(module, lesson)]
    if account is None or not names:
        return {}
    found = repository.load_first_answers(db, account.id, names)
    return {name.removeprefix(f"{module.slug}/"): answer for name, answer in found.items()}


def load_class_answer_counts(db: Session, class_id: UUID, module: Module) -> Mapping[str, Sequence[AnswerCount]]:
    """How a class answered each question of its module, by name; those that nobody answered are not there."""
    found: dict[str, list[AnswerCount]] = {}
    for said in repository.load_answer_counts(
        db, class_id, [f"{module.slug}/{name}" for name in polls_of_module(module)]
    ):
        found.setdefault(said.poll.removeprefix(f"{module.slug}/"), []).append(said)
    return found
