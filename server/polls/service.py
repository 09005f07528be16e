"""The questions of a module's lessons, and what is said to them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from uuid import UUID

from sqlalchemy.orm import Session

from graders.scene.prediction import Prediction
from graders.typography import french
from server.base.errors import Invalid, NotFound
from server.course.code import load_file
from server.course.models import Lesson, Module
from server.identity.models import Account
from server.polls import repository
from server.polls.schemas import Option, Poll, Said

NO_QUESTION = "Cette question n’existe pas."


@lru_cache(maxsize=32)
def of_module(module: Module) -> Mapping[str, Poll]:
    """Every question of a module, by name, in the order of the lessons."""
    return {poll.name: poll for lesson in module.lessons for poll in _of_lesson(lesson)}


def _of_lesson(lesson: Lesson) -> Iterator[Poll]:
    for name in lesson.replays:
        source = load_file(lesson.text.source.path.parents[1] / "rejeux" / f"{name.replace('-', '_')}.py")
        prediction: Prediction | None = getattr(source, "PREDICTION", None)
        if prediction is not None:
            yield _before(lesson, name, source.TITLE, prediction)


def _before(lesson: Lesson, name: str, title: str, asked: Prediction) -> Poll:
    options = tuple(Option(one, french(words), one == asked.right) for one, words in asked.answers)
    href = f"/{lesson.module}/lire/{lesson.slug}#rejeu-{name}"
    return Poll(f"rejeux/{name}", french(title), href, french(asked.question), options, before=True)


def find(module: Module, name: str) -> Poll:
    """Raises NotFound."""
    poll = of_module(module).get(name)
    if poll is None:
        raise NotFound(NO_QUESTION)
    return poll


def say(db: Session, account: Account, module: Module, poll: Poll, answer: str) -> str:
    """Keeps an answer; of what one expects of a replay, the first alone. What was said first. Raises Invalid."""
    if answer not in {option.id for option in poll.options}:
        raise Invalid("Cette réponse n’est pas de celles que la question propose.")
    name = f"{module.slug}/{poll.name}"
    (repository.keep_first if poll.before else repository.keep)(db, account.id, name, answer)
    return repository.first_answers(db, account.id, [name])[name]


def said_in(db: Session, account: Account | None, module: Module, lesson: Lesson) -> Mapping[str, str]:
    """What somebody said first to the questions of a lesson, by name. Nothing of a visitor: their browser keeps it."""
    names = [f"{module.slug}/{poll.name}" for poll in of_module(module).values() if f"/{lesson.slug}#" in poll.href]
    if account is None or not names:
        return {}
    found = repository.first_answers(db, account.id, names)
    return {name.removeprefix(f"{module.slug}/"): answer for name, answer in found.items()}


def spread(db: Session, class_id: UUID, module: Module) -> Mapping[str, Sequence[Said]]:
    """How a class answered each question of its module, by name; those that nobody answered are not there."""
    found: dict[str, list[Said]] = {}
    for said in repository.spread(db, class_id, [f"{module.slug}/{name}" for name in of_module(module)]):
        found.setdefault(said.poll.removeprefix(f"{module.slug}/"), []).append(said)
    return found
