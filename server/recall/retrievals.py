"""Retrieval questions of the lessons: their numbers for an account and a day, and what is stored of the answers."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date, timedelta

from sqlalchemy.orm import Session

from graders.core.answers.retrieval import Marking, RetrievalQuestion, UnreadableAnswerError, make_seed
from server.base import school_time
from server.base.errors import Conflict, Invalid, NotFound
from server.course import Course, Module
from server.course.retrievals import draw_question
from server.database import utc_now
from server.identity.models import Account
from server.recall import repository
from server.recall.models import QuestionKind, RecallAnswer

#: Begins the subjects that are retrieval questions: `rappel:l20/localiser/porte`.
PREFIX = "rappel:"
NO_QUESTION = "Cette question n’existe pas, ou plus."
OTHER_DAY = "Cette question est d’un autre jour : rechargez la page, elle aura de nouveaux nombres."
#: A visitor without an account: all of them get the same numbers.
VISITOR = "visiteur"


@dataclass(frozen=True)
class AskedRetrieval:
    """A question with its numbers of a day. `name` is `lesson/question`; `seed` drew it."""

    module: str
    name: str
    day: date
    seed: int
    question: RetrievalQuestion

    @property
    def options(self) -> tuple[tuple[str, str], ...]:
        """The letters and words of a choice, none of a number."""
        return tuple(self.question.options(self.seed)) if self.question.offers_options else ()

    @property
    def anchor(self) -> str:
        return f"redire-{self.name.partition('/')[2]}"

    @property
    def href(self) -> str:
        return f"/{self.module}/lire/{self.name.partition('/')[0]}#{self.anchor}"


def today_at_school() -> date:
    """Return the day on the school's clock."""
    return school_time.to_local(utc_now()).date()


def require_today_or_yesterday(day: date) -> None:
    """Raise Conflict for a question of another day than today or yesterday."""
    if not timedelta(0) <= today_at_school() - day <= timedelta(days=1):
        raise Conflict(OTHER_DAY)


def draw_retrieval(module: Module, name: str, account: Account | None, day: date) -> AskedRetrieval:
    """Draw a question for an account and a day. Raises NotFound."""
    if name not in module.retrievals:
        raise NotFound(NO_QUESTION)
    seed = make_seed(VISITOR if account is None else str(account.id), module.slug, name, day.isoformat())
    return AskedRetrieval(module.slug, name, day, seed, draw_question(module, name, seed))


def submit_retrieval(db: Session, module: Module, name: str, account: Account | None, day: date, typed: str) -> Marking:
    """Mark an answer to a question of today or yesterday, and store the first one of the day.

    Raises NotFound, Conflict for another day, and Invalid for what is no answer.
    """
    require_today_or_yesterday(day)
    asked = draw_retrieval(module, name, account, day)
    try:
        marking = asked.question.mark(typed, asked.seed)
    except UnreadableAnswerError as error:
        raise Invalid(str(error)) from error
    if account is not None:
        _store_first_answer_of_day(db, account, module, name, is_right=marking.is_right)
    return marking


def _store_first_answer_of_day(db: Session, account: Account, module: Module, name: str, *, is_right: bool) -> None:
    subject = subject_of_retrieval(module.slug, name)
    latest = repository.find_latest_answer_time(db, account.id, subject)
    if latest is None or school_time.to_local(latest).date() != today_at_school():
        page, _, question = name.partition("/")
        repository.add_answer(db, RecallAnswer(
            account_id=account.id, subject=subject, kind=QuestionKind.calculation, exercise=f"{module.slug}/{page}",
            misconception=question, is_right=is_right,
        ))  # fmt: skip


def subject_of_retrieval(module: str, name: str) -> str:
    return f"{PREFIX}{module}/{name}"


def find_retrieval_of_subject(course: Course, subject: str) -> tuple[Module, str] | None:
    """Return the module and name of the question that a subject is; None of other subjects, and of what is gone."""
    module, _, name = subject.removeprefix(PREFIX).partition("/")
    found = course.modules.get(module)
    return (found, name) if subject.startswith(PREFIX) and found is not None and name in found.retrievals else None
