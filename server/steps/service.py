"""Following a program: whose, with what, how often; it is followed by the process that runs cells."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass
from typing import Protocol

from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.assignments import feedback, sittings
from server.base.errors import InternalFailure, Invalid, NotFound, Overloaded, WrongMoment
from server.base.settings import Settings
from server.base.validation import encode_bounded
from server.course import Course, Exercise
from server.course.reuse import Own, shelves
from server.database import Database
from server.gradebook import importable_files
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.limits import service as limits
from server.steps import calls
from server.steps.questions import Asked, AskedCall, AskedCell, AskedReplay, Earlier, Question
from server.steps.replayable import can_replay
from server.steps.schemas import NewCall, NewCell, NewReplay
from server.submissions.service import UNKNOWN_SUBMISSION

TOO_FAST = "Vous avez suivi beaucoup de programmes en peu de temps : le prochain est possible dans {seconds} s."
NO_MODULE = "Ce module n’existe pas."
NO_EXERCISE = "Cet exercice n’existe pas, ou se fait sans code."
NO_REPLAY = "Ce cas ne peut pas être rejoué."
IN_TEST = "Pas de pas à pas pendant le contrôle « {title} » : il revient avec ses résultats."


class Follow(Protocol):
    """Has a question asked, in its turn (see `server.cells.supervisor`)."""

    def __call__(self, question: bytes, *, reader: str, address: str) -> Awaitable[bytes]: ...


@dataclass(frozen=True)
class Steps:
    """Each gives what the page gets, as JSON text. They raise TooMany, Crowded or Failed, beside what they say."""

    course: Course
    database: Database
    settings: Settings
    follow: Follow

    async def of_cell(self, account: Account, module: str, new: NewCell, address: str) -> bytes:
        """A lesson's cell. Raises NotFound, Invalid or TooLarge."""
        if module not in self.course.modules:
            raise NotFound(NO_MODULE)
        source = encode_bounded(_plain(new.code), self.settings.code_bytes)
        return await self._asked(account, address, lambda _: AskedCell(module=module, code=source.decode()))

    async def of_call(self, account: Account, exercise_id: str, new: NewCall, address: str) -> bytes:
        """One's own call of what is in the editor. Raises NotFound, NotNow, Invalid or TooLarge."""
        exercise = self._exercise(exercise_id)
        source = encode_bounded(_plain(new.code), self.settings.code_bytes)
        calls.read(new.call)

        def asked(db: Session) -> Asked:
            if held := feedback.load_holds(db, account.id, exercise.id).tests:
                raise WrongMoment(IN_TEST.format(title=held[0].title))
            sittings.require_no_tested_imports(db, account.id, source, self._reused(exercise.id))
            own = importable_files.load_importable_files_now(db, self.course, account.id, exercise.id, source)
            return AskedCall(
                exercise=exercise.id, source=source, library=self._library(exercise.id, own), call=new.call
            )

        return await self._asked(account, address, asked)

    async def of_check(self, account: Account | None, submission_id: str, new: NewReplay, address: str) -> bytes:
        """The case that a failed check of an attempt shows. Raises NotFound for an attempt that is not theirs to see,
        Invalid for what cannot be replayed, and for what a test holds back. NotNow as `sittings.require_no_help`."""
        if account is None:
            raise NotFound(UNKNOWN_SUBMISSION)

        def asked(db: Session) -> Asked:
            attempt = gradebook.find_attempt(db, account, submission_id)
            sent, verdict = attempt.submission, attempt.verdict
            check = next((one for one in verdict.checks if one.id == new.check), None) if verdict else None
            exercise = self.course.exercises.get(sent.exercise)
            if verdict is None or check is None or exercise is None or not can_replay(exercise, check):
                raise Invalid(NO_REPLAY)
            assert check.counterexample is not None
            sittings.require_no_tested_imports(db, account.id, sent.source, self._reused(exercise.id))
            own = importable_files.load_importable_files(db, self.course, sent)
            return AskedReplay(
                exercise=exercise.id,
                source=sent.source,
                library=self._library(exercise.id, own),
                check=check.id,
                inputs=check.counterexample.inputs,
                seed=verdict.seed,
                limits=asdict(exercise.policy),
                mistakes=(verdict.diagnosis.id,) if verdict.diagnosis else (),
            )

        return await self._asked(account, address, asked)

    def _exercise(self, exercise_id: str) -> Exercise:
        exercise = self.course.exercises.get(exercise_id)
        if exercise is None or exercise.kind != "code":
            raise NotFound(NO_EXERCISE)
        return exercise

    def _reused(self, exercise: str) -> list[str]:
        return [one.id for one in self.course.reused(exercise)]

    def _library(self, exercise: str, own: Own) -> tuple[Earlier, ...]:
        return tuple(map(Earlier.of, shelves(self.course, exercise, own)))

    async def _asked(self, account: Account, address: str, ask: Callable[[Session], Asked]) -> bytes:
        """Takes one of the account's tokens, given back where nothing was followed."""
        key = f"steps:{account.id}"

        def prepared() -> bytes:
            with self.database.read() as db:
                question = Question(steps=ask(db))
            with self.database.write() as db:
                limits.take_token(db, key, self.settings.step_bucket, TOO_FAST)
            return question.model_dump_json().encode()

        def give_back() -> None:
            with self.database.write() as db:
                limits.give_back_token(db, key)

        question = await run_in_threadpool(prepared)
        try:
            return await self.follow(question, reader=str(account.id), address=address)
        except (Overloaded, InternalFailure):
            await run_in_threadpool(give_back)
            raise


def _plain(code: str) -> str:
    return code.replace("\r\n", "\n")
