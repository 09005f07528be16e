"""Hunts for the pages: checks rights and rate limits, asks the process that runs cells, stores what was answered."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from hashlib import blake2b
from typing import Any

import numpy as np
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from graders.core.code.grading import CodeGrader
from graders.core.code.hunts import list_hunts
from graders.core.declared import hunts as declared
from graders.core.declared.grading import DeclaredGrader
from server.assignments import feedback
from server.base.errors import Forbidden, InternalFailure, NotFound, Overloaded, WrongMoment
from server.base.settings import Settings
from server.classes import presence
from server.course import Course, Exercise
from server.database import Database
from server.gradebook import mistakes
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET
from server.hunts.protocol import (
    AnswerComparison,
    ComparisonRequest,
    HuntName,
    HuntQuestion,
    HuntReply,
    HuntTrialOutcome,
    InputTrial,
    LineTrial,
    OfferedHunt,
    OfferRequest,
    PredictionTrial,
    PreparationRequest,
    ProgramReview,
    ReviewRequest,
)
from server.identity.models import Account
from server.limits import service as limits
from server.queue.interfaces import Sender
from server.recall import repository
from server.recall.calculations import has_calculation_questions
from server.recall.models import QuestionKind, RecallAnswer
from server.recall.service import RecallCandidate
from server.recall.subjects import iter_misconceptions, subject_of_misconception
from server.steps.service import TraceProgram
from server.submissions.queue_senders import sender_of_account

TOO_FAST = "Vous avez essayé beaucoup d’entrées en peu de temps : la prochaine est possible dans {seconds} s."
NO_EXERCISE = "Cet exercice n’existe pas, ou n’a pas de chasse aux erreurs."
FIRST_SOLVE = "Réussissez d’abord « {title} » : ses chasses aux erreurs s’ouvrent alors."
IN_TEST = "Pas de chasse aux erreurs pendant le contrôle « {title} » : elle revient avec ses résultats."
MAX_TYPED_CHARACTERS = 600
#: Arguments of one function, whose values come in as many fields.
MAX_ARGUMENTS = 8


@dataclass(frozen=True)
class HuntService:
    """Every method may also raise RateLimited, Overloaded or InternalFailure."""

    course: Course
    database: Database
    settings: Settings
    ask: TraceProgram
    prepare: Callable[[bytes], None]

    async def start_process_early(self) -> None:
        """Prepare the process that makes hunts, for a reader who may ask for one at a click. Waits for nothing."""
        self.prepare(HuntQuestion(hunts=PreparationRequest()).model_dump_json().encode())

    async def offer_hunt(
        self, account: Account, exercise_id: str, skipped_count: int, address: str
    ) -> OfferedHunt | None:
        """Offer a hunt of an exercise after `skipped_count` of them, the reader's own mistakes first; None where none
        is left.

        Raises NotFound, Forbidden or WrongMoment.
        """
        exercise = self._find_exercise(exercise_id)

        def names(db: Session) -> Sequence[HuntName]:
            require_may_hunt_mistakes(db, account, exercise)
            own = [mistake.misconception for mistake in mistakes.load_past_mistakes(db, account.id, [exercise.id])]
            return order_hunts_for_account(exercise, own, account)

        hunts = await self._load_in_transaction(names)
        offer = await self.offer_first_possible_hunt(account, hunts[skipped_count:], address)
        return None if offer is None else offer.model_copy(update={"index": offer.index + skipped_count})

    async def offer_hunt_again(self, account: Account, hunt: HuntName, address: str) -> OfferedHunt | None:
        """Offer a hunt again, by its name. Raises as `offer_hunt`."""
        exercise = self._find_exercise(hunt.exercise)
        await self._load_in_transaction(lambda db: require_may_hunt_mistakes(db, account, exercise))
        return await self.offer_first_possible_hunt(account, [hunt], address)

    async def offer_first_possible_hunt(
        self, account: Account, hunts: Sequence[HuntName], address: str
    ) -> OfferedHunt | None:
        """Offer the first of these hunts that can be made; the caller knows that the account may see them."""
        if not hunts:
            return None
        # The process answers questions about declared exercises apart: those of one exercise go together.
        declared = [name for name in hunts if self._load_declarations([name])]
        asked = declared if declared and hunts[0] == declared[0] else [name for name in hunts if name not in declared]
        offer = OfferRequest(hunts=tuple(asked), seed=program_form_seed(account, asked[0].exercise))
        question = HuntQuestion(hunts=offer, declarations=self._load_declarations(asked))
        found = (await self._ask_process_with_rate_limit(account, question, address)).offer
        return found and found.model_copy(update={"index": hunts.index(asked[found.index])})

    async def try_input(
        self, account: Account, hunt: HuntName, typed: Mapping[str, str], address: str
    ) -> HuntTrialOutcome:
        """Run both programs on a typed input, and store whether it shows the mistake. Raises as `offer_hunt`."""
        return await self._try_and_store_answer(
            account, hunt, InputTrial(hunt=hunt, typed=dict(typed)), QuestionKind.hunt, address
        )

    async def try_prediction(self, account: Account, hunt: HuntName, typed: str, address: str) -> HuntTrialOutcome:
        """Compare a typed value with the wrong program's answer, and store whether it is that. Raises as
        `offer_hunt`."""
        trial = PredictionTrial(hunt=hunt, typed=typed)
        return await self._try_and_store_answer(account, hunt, trial, QuestionKind.prediction, address)

    async def try_line(self, account: Account, hunt: HuntName, line: int, address: str) -> HuntTrialOutcome:
        """Say whether a line makes the program wrong, and store whether it does. Raises as `offer_hunt`."""
        trial = LineTrial(hunt=hunt, seed=program_form_seed(account, hunt.exercise), line=line)
        return await self._try_and_store_answer(account, hunt, trial, QuestionKind.line, address)

    async def store_no_answer_found(self, account: Account, hunt: HuntName, kind: QuestionKind) -> None:
        """Store that no answer was found. Raises as `offer_hunt`."""
        exercise = self._find_exercise(hunt.exercise)
        await self._load_in_transaction(lambda db: require_may_hunt_mistakes(db, account, exercise))
        await self.store_answer(account, exercise, hunt.misconception, kind, is_right=False)

    async def find_distinguishing_call(
        self, account: Account, hunts: Sequence[HuntName], address: str
    ) -> AnswerComparison | None:
        """Return a call on which students differ, from the first of these hunts that gives one; None where none does.

        The caller knows that the mistakes may be told. Declared exercises give none.
        """
        asked = [name for name in hunts if not self._load_declarations([name])]
        if not asked:
            return None
        question = HuntQuestion(hunts=ComparisonRequest(hunts=tuple(asked)))
        return (await self._ask_process_with_rate_limit(account, question, address)).comparison

    async def review_program(self, account: Account, exercise: Exercise, source: str, address: str) -> ProgramReview:
        """Say what could be written otherwise in a program that passes, which the account may see."""
        question = HuntQuestion(hunts=ReviewRequest(exercise=exercise.id, source=source))
        return (await self._ask_process_with_rate_limit(account, question, address)).review or ProgramReview()

    async def _try_and_store_answer(
        self,
        account: Account,
        hunt: HuntName,
        trial: InputTrial | PredictionTrial | LineTrial,
        kind: QuestionKind,
        address: str,
    ) -> HuntTrialOutcome:
        exercise = self._find_exercise(hunt.exercise)
        await self._load_in_transaction(lambda db: require_may_hunt_mistakes(db, account, exercise))
        question = HuntQuestion(hunts=trial, declarations=self._load_declarations([hunt]))
        reply = await self._ask_process_with_rate_limit(account, question, address)
        if reply.outcome is None:
            raise InternalFailure("La question n’a pas pu être posée : l’incident est de notre côté. Réessayez.")
        # A wrong input is no answer yet: one looks on. A wrong prediction is one, and so is a wrong line.
        if reply.outcome.is_right or (kind is not QuestionKind.hunt and not reply.outcome.refusal):
            await self.store_answer(account, exercise, hunt.misconception, kind, is_right=reply.outcome.is_right)
        return reply.outcome

    async def store_answer(
        self, account: Account, exercise: Exercise, misconception: str, kind: QuestionKind, *, is_right: bool
    ) -> None:
        """Store an answer in a transaction of its own."""
        answer = RecallAnswer(
            account_id=account.id, subject=subject_of_misconception(self.course, exercise, misconception), kind=kind,
            exercise=exercise.id, misconception=misconception, is_right=is_right,
        )  # fmt: skip

        def write() -> None:
            with self.database.write() as db:
                repository.add_answer(db, answer)

        await run_in_threadpool(write)

    def _load_declarations(self, hunts: Sequence[HuntName]) -> dict[str, dict[str, Any]]:
        """Return the declarations of those exercises that are declared."""
        names = dict.fromkeys(hunt.exercise for hunt in hunts)
        graders = {name: self.course.exercises[name].grader for name in names if name in self.course.exercises}
        return {
            name: dict(grader.declaration.data)
            for name, grader in graders.items()
            if isinstance(grader, DeclaredGrader)
        }

    def _find_exercise(self, exercise_id: str) -> Exercise:
        exercise = self.course.exercises.get(exercise_id)
        if exercise is None or not may_have_hunts(self.course, exercise):
            raise NotFound(NO_EXERCISE)
        return exercise

    async def _load_in_transaction(self, load: Callable[[Session], Sequence[HuntName] | None]) -> Sequence[HuntName]:
        def read() -> Sequence[HuntName]:
            with self.database.read() as db:
                return load(db) or ()

        return await run_in_threadpool(read)

    async def _ask_process_with_rate_limit(self, account: Account, question: HuntQuestion, address: str) -> HuntReply:
        """Take a rate-limit token, ask, and give the token back if there was no answer."""
        key = f"hunts:{account.id}"

        def prepare() -> Sender:
            with self.database.read() as db:
                sender = sender_of_account(account, address, member=presence.is_active_member(db, account.id))
            with self.database.write() as db:
                limits.take_token(db, key, self.settings.step_bucket, TOO_FAST)
            return sender

        def give_back() -> None:
            with self.database.write() as db:
                limits.give_back_token(db, key)

        sender = await run_in_threadpool(prepare)
        try:
            asked = question.model_dump_json().encode()
            answer = await self.ask(asked, reader=str(account.id), flow=sender.flow, rank=sender.rank)
        except (Overloaded, InternalFailure):
            await run_in_threadpool(give_back)
            raise
        return HuntReply.model_validate_json(answer)


def may_have_hunts(course: Course, exercise: Exercise) -> bool:
    """Whether an exercise may have hunts: its author has not refused them, and knows mistakes. Loads its grader."""
    return exercise.hunts != "never" and _has_hunts_in_grader(exercise)


def may_ask_about_mistakes_again(course: Course, exercise: Exercise) -> bool:
    """Whether what was confused in an exercise may be asked again: by a hunt, a small calculation or a choice."""
    return has_calculation_questions(exercise) or may_have_hunts(course, exercise)


@lru_cache(maxsize=512)
def _has_hunts_in_grader(exercise: Exercise) -> bool:
    if exercise.kind != "code":
        return False
    grader = exercise.grader
    if isinstance(grader, DeclaredGrader):
        return any(declared.list_hunts(grader))
    return isinstance(grader, CodeGrader) and any(list_hunts(grader))


def require_may_hunt_mistakes(db: Session, account: Account, exercise: Exercise) -> None:
    """Raise Forbidden before the exercise is solved, WrongMoment while a test asks it."""
    if tests := feedback.load_holds(db, account.id, exercise.id).tests:
        raise WrongMoment(IN_TEST.format(title=tests[0].title))
    if exercise.hunts == "always" or account.is_teacher:
        return
    if not gradebook.load_progress(db, account, exercise.id).get(exercise.id, NOTHING_YET).succeeded:
        raise Forbidden(FIRST_SOLVE.format(title=exercise.title))


def order_hunts_for_account(
    exercise: Exercise, own_misconceptions: Collection[str], account: Account
) -> list[HuntName]:
    """Return the hunts of an exercise: one's own mistakes first, then the others in an order of one's own."""
    filed, grader = list(iter_misconceptions(exercise)), exercise.grader
    names = filed if not isinstance(grader, DeclaredGrader) else [it.id for it in grader.declaration.mistakes]
    rank = {name: place for place, name in enumerate(dict.fromkeys(own_misconceptions))}
    shuffled = [
        names[k] for k in np.random.default_rng(program_form_seed(account, exercise.id)).permutation(len(names))
    ]
    ordered = sorted(shuffled, key=lambda name: rank.get(name, len(rank)))
    return [HuntName(exercise=exercise.id, misconception=name) for name in ordered]


def hunt_names_of_misconceptions(candidates: Iterable[RecallCandidate]) -> list[HuntName]:
    """Return the hunts of misconceptions, whichever function of the exercise makes them."""
    return [HuntName(exercise=candidate.exercise, misconception=candidate.misconception) for candidate in candidates]


def choose_question_kind(offer: OfferedHunt, turn: int) -> QuestionKind:
    """Return the question of a turn, of those that can be asked about a hunt."""
    kinds = [QuestionKind.hunt]
    kinds += [QuestionKind.prediction] if offer.predictable else []
    kinds += [QuestionKind.line] if offer.wrong_lines else []
    return kinds[turn % len(kinds)]


def program_form_seed(account: Account, exercise: str) -> int:
    """Return the seed of the form in which an account sees the programs of an exercise."""
    return int.from_bytes(blake2b(f"{account.id}:{exercise}".encode(), digest_size=6).digest(), "big")
