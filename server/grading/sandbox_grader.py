"""The bridge between sandbox and graders: a student's file in, a verdict out.

A student's fault becomes a verdict. Ours (the sandbox, a grader, this file) is retried once, logged in full, and ends
as `internal_error`.
"""

import hashlib
import logging
import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from uuid import UUID

from graders.core.code.grading import CodeGrader
from graders.core.code.mending import start_time_limit
from graders.core.code.places import add_place_to_diagnosis, find_place
from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, Block, KitSettings, PlannedCalls, Reply, StudentFault
from graders.core.contract.protocol import WhileNaming
from graders.core.contract.rows import ArrayReplies, Rows
from graders.core.contract.values import Arguments, Value
from graders.core.contract.verdict import Diagnosis, Verdict, internal_error_verdict
from server import sandbox
from server.behaviour.limits import SEARCH_SECONDS, widen_limits_for_search
from server.course import reuse
from server.course.models import UNKNOWN_VERSION, Course
from server.course.reuse import NOTHING_OWN, Own
from server.sandbox import CallBatch, Frame, Kit, LibraryFile, Policy, ProgramFault, Sandbox, Session, judging_too_long
from server.sandbox.seat import seat_clock

log = logging.getLogger(__name__)

TRIES = 2
#: Divides the time of further launches of a file that has run out of it. The course's solutions take a twentieth of it.
SHORTENING = 4.0
TIMED_OUT = "Une fonction a épuisé son temps : celles qui ont été appelées ensuite n’en ont eu que le quart."
FILENAME = "solution.py"
#: Characters of the sentence that says why a file does not load.
MAX_LOAD_ERROR = 600


class JudgingTimeBudget:
    """The processor time for reading and comparing the answers of one submission, in this thread.

    Answers are bounded in size, so that only values made for it exhaust the budget: the student's fault, not ours.
    """

    def __init__(self, policy: Policy) -> None:
        self._policy, self._started = policy, time.thread_time()

    def fault_if_exhausted(self) -> StudentFault | None:
        """Return the fault that answers every call once the budget is exhausted."""
        if time.thread_time() - self._started <= self._policy.judging_seconds:
            return None
        return StudentFault(Outcome.OUTPUT_LIMIT, judging_too_long(self._policy), fatal=True)

    def raise_if_exhausted(self) -> None:
        """Raise StudentFault once the budget is exhausted."""
        if fault := self.fault_if_exhausted():
            raise fault


class SandboxProgram:
    """A student's program in the sandbox, as graders see it."""

    def __init__(
        self, session: Session, budget: JudgingTimeBudget, ahead: Sequence[PlannedCalls], ended: list[Session]
    ) -> None:
        """`ended` gets the session once it is closed."""
        self._session, self._budget, self._ahead, self._ended = session, budget, ahead, ended
        self.functions = frozenset(session.functions)

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        self._budget.raise_if_exhausted()
        try:
            reply = self._session.call(function, *args, return_arguments=return_arguments)
        except ProgramFault as fault:
            raise convert_to_student_fault(fault) from fault
        return Reply(reply.value, reply.arguments)

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        for answer in self._session.call_many(function, calls, faults=faults):
            if fault := self._budget.fault_if_exhausted():
                yield fault
                return
            yield _convert_answer(answer)

    def call_batches(self, requests: Sequence[PlannedCalls]) -> Iterator[Block]:
        blocks = (
            self._session.first_answers
            if requests is self._ahead
            else self._session.call_batches(list(map(_convert_planned_calls, requests)))
        )
        for number, answers in blocks:
            if fault := self._budget.fault_if_exhausted():
                yield number, (fault,)
                return
            if isinstance(answers, sandbox.Replies):
                yield number, ArrayReplies(answers.values)
            else:
                yield number, [_convert_answer(answer) for answer in answers]

    def stdout(self) -> str:
        return self._session.stdout()

    def close(self) -> None:
        self._session.close()
        ended, self._ended = self._ended, []  # closed again, it is not counted again
        ended.append(self._session)


class SandboxPrograms:
    """Starts a student's file in the sandbox, under the policy of one exercise, for one grading.

    `library` is what the file may import from `mes_fonctions`. Once it has run out of time, its other launches have a
    quarter of that: a file whose functions all loop does not take the time of all of them.
    """

    def __init__(
        self, sandbox: Sandbox, policy: Policy, library: Sequence[LibraryFile] = (), asked: Sequence[str] = ()
    ) -> None:
        """`asked` are the functions that the file must define."""
        self._sandbox, self._policy, self._budget = sandbox, policy, JudgingTimeBudget(policy)
        self._library = tuple(library)
        #: What was let through in the file, and why it did not load, as of its first start.
        self.remarks: tuple[str, ...] = ()
        self.load_error = ""
        self._asked, self._has_started = tuple(asked), False
        self._sessions, self._opened = list[Session](), list[Session]()
        self._ended, self._ended_cpu_seconds = list[Session](), 0.0
        #: The seat's: while its programs are stopped, no limit of theirs passes.
        self.clock = seat_clock()

    @property
    def cpu_seconds(self) -> float:
        """The processor time of the programs that were loaded, which this closes. Raises SandboxFault."""
        return sum(session.usage.cpu_seconds for session in self._opened)

    def ended_cpu_seconds(self) -> float:
        """Return the processor time of the programs that were closed by now. Raises SandboxFault."""
        while self._ended:
            self._ended_cpu_seconds += self._ended.pop().usage.cpu_seconds
        return self._ended_cpu_seconds

    def prepare(self, source: bytes, kit: KitSettings, launches: int) -> None:
        self._sandbox.prepare(source, launches, kit=self._load_kit(kit), policy=self._policy)

    def _load_kit(self, kit: KitSettings) -> Kit:
        return Kit(kit.module, dict(kit.parameters), kit.without, self._library)

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> SandboxProgram:
        self._budget.raise_if_exhausted()
        settings = self._load_kit(kit)
        self._shorten_time_limits_after_timeout()
        try:
            session = self._sandbox.open(
                source,
                kit=settings,
                policy=self._policy,
                filename=FILENAME,
                first_calls=list(map(_convert_planned_calls, ahead)),
            )
        except ProgramFault as fault:
            if not self._has_started:
                self.load_error = _first_paragraph(fault.message)
            raise convert_to_student_fault(fault) from fault
        finally:
            is_first, self._has_started = not self._has_started, True
        if is_first:
            self.remarks, self.load_error = session.remarks, session.describe_missing(self._asked)
        self._sessions.append(session)
        self._opened.append(session)
        return SandboxProgram(session, self._budget, ahead, self._ended)

    def _shorten_time_limits_after_timeout(self) -> None:
        if not any(session.has_timed_out for session in self._sessions):
            return
        self._sessions.clear()
        if TIMED_OUT not in self.remarks:
            seconds = (self._policy.cpu_seconds / SHORTENING, self._policy.wall_seconds / SHORTENING)
            self._policy = replace(self._policy, cpu_seconds=seconds[0], wall_seconds=seconds[1])
            self.remarks += (TIMED_OUT,)


def _first_paragraph(message: str) -> str:
    return message.partition("\n")[0][:MAX_LOAD_ERROR]


def _convert_planned_calls(planned: PlannedCalls) -> CallBatch:
    columns = planned.calls.columns if isinstance(planned.calls, Rows) else None
    return CallBatch(planned.function, planned.calls, planned.faults, planned.return_arguments, columns)


def _convert_answer(answer: sandbox.Reply | ProgramFault) -> Answer:
    return (
        convert_to_student_fault(answer) if isinstance(answer, ProgramFault) else Reply(answer.value, answer.arguments)
    )


def convert_to_student_fault(fault: ProgramFault) -> StudentFault:
    """Convert the sandbox's report of a fault to the graders' one."""
    frames = tuple(_format_frame(frame) for frame in fault.frames)
    return StudentFault(
        Outcome(fault.kind.value),
        fault.message,
        line=fault.line,
        frames=frames,
        fatal=fault.fatal,
        exception=fault.exception,
    )


def _format_frame(frame: Frame) -> str:
    location = f"ligne {frame.line}, dans {frame.function}"
    return f"{location} : {frame.source.strip()}" if frame.source else location


class SandboxGrader:
    """Grades files with one sandbox; thread-safe as far as the sandbox is."""

    def __init__(self, course: Course, sandbox: Sandbox) -> None:
        self._course = course
        self._sandbox = sandbox

    def program_starter(
        self, exercise_id: str, policy: Policy, own: Own = NOTHING_OWN, exercises_under_test: Collection[str] = ()
    ) -> SandboxPrograms:
        """Return a starter of files for one grading of an exercise, under a policy; the others are as in `grade`."""
        library = reuse.build_importable_library(self._course, exercise_id, own, exercises_under_test)
        asked = [function.name for function in self._course.exercises[exercise_id].functions]
        return SandboxPrograms(self._sandbox, policy, library, asked)

    def locate_mistakes(
        self, exercise_id: str, source: bytes, verdict: Verdict, *, own: Own = NOTHING_OWN, seconds: float
    ) -> Diagnosis | None:
        """Return the verdict's diagnosis with the places of the mistakes, searched for so many seconds of processor."""
        exercise = self._course.exercises[exercise_id]
        if not isinstance(exercise.grader, CodeGrader):
            return verdict.diagnosis
        programs = self.program_starter(exercise_id, widen_limits_for_search(exercise.policy), own)
        spent = start_time_limit(SEARCH_SECONDS, seconds, programs)
        found = find_place(exercise.grader, source.decode("utf-8", "replace"), verdict, programs, spent)
        return verdict.diagnosis if found is None else add_place_to_diagnosis(verdict.diagnosis, found.diagnosis)

    def grade(
        self,
        exercise_id: str,
        source: bytes,
        seed: int,
        *,
        submission: UUID | None = None,
        own: Own = NOTHING_OWN,
        tested: Collection[str] = (),
        policy: Policy | None = None,
        while_naming: WhileNaming | None = None,
    ) -> Judgement:
        """Grade a file. Never raises for a reason of ours: after a second failure the verdict is `internal_error`.

        `own` holds the files whose functions the program imports from `mes_fonctions` instead of the course's; those of
        `tested` exercises are not given; `policy` replaces the limits of the exercise. `while_naming` is as in
        `Grader.grade`.
        """
        version = UNKNOWN_VERSION
        for try_number in range(1, TRIES + 1):
            try:
                exercise = self._course.exercises[exercise_id]
                version = exercise.version
                programs = self.program_starter(exercise_id, policy or exercise.policy, own, tested)
                early = (
                    {"while_naming": _complete_judgements_while_naming(while_naming, programs)} if while_naming else {}
                )
                judgement = exercise.grader.grade(source, programs, seed=seed, version=version, **early)
                verdict = replace(judgement.verdict, remarks=programs.remarks, load_error=programs.load_error)
                return replace(judgement, verdict=verdict)
            except Exception:
                # Enough to reproduce the grading: the source is in the database, or the caller has it.
                digest = hashlib.sha256(source).hexdigest()
                log.exception(
                    "grading %s (version %s) with seed %d failed, try %d of %d: submission %s, %d bytes, sha256 %s",
                    *(exercise_id, version, seed, try_number, TRIES, submission or "by hand", len(source), digest),
                )
        return Judgement(internal_error_verdict(exercise_id, version, seed))


def _complete_judgements_while_naming(while_naming: WhileNaming, programs: SandboxPrograms) -> WhileNaming:
    """Return `while_naming` of judgements with what the sandbox says of the file."""
    return lambda judgement: while_naming(
        replace(
            judgement,
            verdict=replace(judgement.verdict, remarks=programs.remarks, load_error=programs.load_error),
        )
    )
