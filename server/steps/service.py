"""Traces programs for the pages: checks rights and rate limits, then asks the process that runs cells."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection
from dataclasses import asdict, dataclass
from typing import Protocol

from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from graders.core.contract.kits import SCENARIOS
from graders.core.contract.verdict import CheckResult
from graders.core.declared.grading import DeclaredGrader
from server.assignments import feedback, sittings
from server.base.errors import InternalFailure, Invalid, NotFound, Overloaded, WrongMoment
from server.base.settings import Settings
from server.base.validation import encode_bounded
from server.classes import presence
from server.course import Course, Exercise
from server.course.reuse import Own, build_importable_library
from server.database import Database, utc_now
from server.gradebook import importable_files
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.limits import service as limits
from server.queue.interfaces import Sender
from server.steps import calls
from server.steps.questions import (
    CallTraceRequest,
    CellTraceRequest,
    LibraryFileData,
    ProgramRunRequest,
    ReplayTraceRequest,
    ScenarioTraceRequest,
    TraceQuestion,
    TraceRequest,
)
from server.steps.replayable import can_replay
from server.steps.schemas import CallBody, CellBody, ReplayBody
from server.submissions.queue_senders import sender_of_account
from server.submissions.service import UNKNOWN_SUBMISSION

TOO_FAST = "Vous avez suivi beaucoup de programmes en peu de temps : le prochain est possible dans {seconds} s."
#: Seed of the kit of a program that is run, so that each run draws the same.
SEED = 20
NO_MODULE = "Ce module n’existe pas."
NO_EXERCISE = "Cet exercice n’existe pas, ou se fait sans code."
NO_REPLAY = "Ce cas ne peut pas être rejoué."
IN_TEST = "Pas de pas à pas pendant le contrôle « {title} » : il revient avec ses résultats."


class TraceProgram(Protocol):
    """Sends a question to the tracing process, in its turn (see `server.cells.supervisor`)."""

    def __call__(self, question: bytes, *, reader: str, flow: str, rank: int = 0) -> Awaitable[bytes]: ...


@dataclass(frozen=True)
class StepService:
    """Traces as JSON text for the page. Every method may also raise TooMany, Crowded or Failed."""

    course: Course
    database: Database
    settings: Settings
    trace_program: TraceProgram

    async def trace_cell(self, account: Account, module: str, new: CellBody, address: str) -> bytes:
        """Trace a lesson's cell. Raises NotFound, Invalid or TooLarge."""
        if module not in self.course.modules:
            raise NotFound(NO_MODULE)
        source = encode_bounded(_unix_newlines(new.code), self.settings.code_bytes)
        return await self._trace_within_rate_limit(
            account, address, lambda _: CellTraceRequest(module=module, code=source.decode())
        )

    async def trace_call(self, account: Account, exercise_id: str, new: CallBody, address: str) -> bytes:
        """Trace a typed call of the code in the editor. Raises NotFound, NotNow, Invalid or TooLarge."""
        exercise = self._find_code_exercise(exercise_id)
        source = encode_bounded(_unix_newlines(new.code), self.settings.code_bytes)
        is_program = new.plain and not new.call.strip() and any(wanted.is_program for wanted in exercise.functions)
        if new.call.strip() or not new.plain:
            calls.parse_call(new.call)
        after = _unix_newlines(new.after)
        whole = source + encode_bounded(f"\n{after}", self.settings.code_bytes)

        def build(db: Session) -> TraceRequest:
            if tests := feedback.load_holds(db, account.id, exercise.id).tests:
                raise WrongMoment(IN_TEST.format(title=tests[0].title))
            if is_program and isinstance(exercise.grader, DeclaredGrader):
                return _build_program_request(exercise.grader, source, new.stdin)
            sittings.require_no_tested_imports(db, account.id, whole, self._reused_exercises(exercise.id))
            own = importable_files.load_importable_files_now(db, self.course, account.id, exercise.id, whole)
            tested = sittings.load_exercises_in_sat_tests(db, account.id, utc_now())
            return CallTraceRequest(
                exercise=exercise.id,
                source=source,
                library=self._build_library(exercise.id, own, tested),
                call=new.call,
                is_declared=exercise.kit == SCENARIOS,
                plain=new.plain,
                after=after,
            )

        return await self._trace_within_rate_limit(account, address, build)

    async def trace_check(self, account: Account | None, submission_id: str, new: ReplayBody, address: str) -> bytes:
        """Trace the case of a failed check of an attempt.

        Raises NotFound for an attempt that the account may not see, Invalid for a case that cannot be replayed or is
        held back by a test, NotNow as `sittings.require_no_help`.
        """
        if account is None:
            raise NotFound(UNKNOWN_SUBMISSION)

        def build(db: Session) -> TraceRequest:
            attempt = gradebook.find_attempt(db, account, submission_id)
            submission, verdict = attempt.submission, attempt.verdict
            check = (
                next((candidate for candidate in verdict.checks if candidate.id == new.check), None)
                if verdict
                else None
            )
            exercise = self.course.exercises.get(submission.exercise)
            if verdict is None or check is None or exercise is None or not can_replay(exercise, check):
                raise Invalid(NO_REPLAY)
            if isinstance(exercise.grader, DeclaredGrader):
                return _build_scenario_request(exercise.grader, check, submission.source, verdict.seed)
            assert check.counterexample is not None
            sittings.require_no_tested_imports(db, account.id, submission.source, self._reused_exercises(exercise.id))
            own = importable_files.load_importable_files(db, self.course, submission)
            tested = importable_files.load_exercises_in_sat_tests(db, self.course, submission)
            tested |= sittings.load_exercises_in_sat_tests(db, account.id, utc_now())
            return ReplayTraceRequest(
                exercise=exercise.id,
                source=submission.source,
                library=self._build_library(exercise.id, own, tested),
                check=check.id,
                inputs=check.counterexample.inputs,
                seed=verdict.seed,
                limits=asdict(exercise.policy),
                mistakes=(verdict.diagnosis.id,) if verdict.diagnosis else (),
            )

        return await self._trace_within_rate_limit(account, address, build)

    def _find_code_exercise(self, exercise_id: str) -> Exercise:
        exercise = self.course.exercises.get(exercise_id)
        if exercise is None or exercise.kind != "code":
            raise NotFound(NO_EXERCISE)
        return exercise

    def _reused_exercises(self, exercise: str) -> list[str]:
        return [reused.id for reused in self.course.importable_exercises(exercise)]

    def _build_library(self, exercise: str, own: Own, tested: Collection[str]) -> tuple[LibraryFileData, ...]:
        return tuple(map(LibraryFileData.from_file, build_importable_library(self.course, exercise, own, tested)))

    async def _trace_within_rate_limit(
        self, account: Account, address: str, build: Callable[[Session], TraceRequest]
    ) -> bytes:
        """Take a rate-limit token of the account, trace, and give the token back if nothing was traced."""
        key = f"steps:{account.id}"

        def prepare() -> tuple[bytes, Sender]:
            with self.database.read() as db:
                question = TraceQuestion(steps=build(db))
                sender = sender_of_account(account, address, member=presence.is_active_member(db, account.id))
            with self.database.write() as db:
                limits.take_token(db, key, self.settings.step_bucket, TOO_FAST)
            return question.model_dump_json().encode(), sender

        def give_back() -> None:
            with self.database.write() as db:
                limits.give_back_token(db, key)

        question, sender = await run_in_threadpool(prepare)
        try:
            return await self.trace_program(question, reader=str(account.id), flow=sender.flow, rank=sender.rank)
        except (Overloaded, InternalFailure):
            await run_in_threadpool(give_back)
            raise


def _build_scenario_request(
    grader: DeclaredGrader, check: CheckResult, source: bytes, seed: int
) -> ScenarioTraceRequest:
    """Return the request to play the case of a failed check again. Raises Invalid."""
    scenario = grader.find_failing_case(check)
    if scenario is None or check.case is None:
        raise Invalid(NO_REPLAY)
    return ScenarioTraceRequest(
        source=source,
        functions=grader.functions,
        case=check.case,
        lines=scenario.lines,
        files=scenario.files,
        kit=dict(grader.kit(seed).parameters),
        imports=dict(grader.declaration.imported_names),
    )


def _build_program_request(grader: DeclaredGrader, source: bytes, stdin: str) -> ProgramRunRequest:
    """Return the request to run a whole program that reads `stdin`. Raises Invalid or TooLarge."""
    lines, kit = calls.parse_stdin_lines(stdin), dict(grader.kit(SEED).parameters)
    return ProgramRunRequest(source=source, function=grader.functions[0], lines=lines, kit=kit)


def _unix_newlines(code: str) -> str:
    return code.replace("\r\n", "\n")
