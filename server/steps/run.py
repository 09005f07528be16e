"""Following one program: in the sandbox, with the kit that it is graded with, to what the page shows."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

from graders import discovery
from graders.core.code.exercise import CodeDefinition
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, Reply
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments, same_value
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import FaultKind, Kit, Policy, ProgramFault, Sandbox, TraceResult, Value
from server.steps import calls, marks, replaying, trace_messages, values
from server.steps.questions import Asked, AskedCall, AskedCell, AskedReplay, Earlier, Question
from server.steps.schemas import EndOut, MarkOut, TraceOut
from server.steps.trace_reader import VALUE, Told
from server.steps.values import Malformed
from server.text.plain import visible

KIB, MIB = 1 << 10, 1 << 20
FILENAME, CELL = "solution.py", "cellule.py"
#: Of one's own calls: the same each time that they are made. A cell's is that of its run.
SEED = 20
#: What a program that is followed may use. Its answer is one step: of these, and of all of them, the tracer has bounds
#: of its own, below.
POLICY = Policy(
    cpu_seconds=4.0,
    wall_seconds=5.0,
    memory_bytes=512 * MIB,
    stdout_bytes=32 * KIB,
    frame_bytes=1 * MIB,
    items=150_000,
    session_bytes=24 * MIB,
    session_items=1_500_000,
    depth=24,
)


@dataclass(frozen=True)
class _Program:
    """A source, the call of it (None: its top level), what it finds, and what is said of the whole."""

    source: bytes
    filename: str
    function: str | None
    arguments: Arguments
    named: Mapping[str, Value]
    kit: Kit
    call: str = ""
    drawing: bool = False


def answer(sandbox: Sandbox, question: Question) -> TraceOut:
    """Raises SandboxFault, or whatever a grader raises, when the fault is ours."""
    start = time.monotonic()
    trace = _answered(sandbox, question.steps)
    return trace.model_copy(update={"milliseconds": round(1000 * (time.monotonic() - start))})


def _answered(sandbox: Sandbox, asked: Asked) -> TraceOut:
    match asked:
        case AskedCell():
            return _cell(sandbox, asked)
        case AskedCall():
            return _call(sandbox, asked)
        case AskedReplay():
            return _replay(sandbox, asked)


def _cell(sandbox: Sandbox, asked: AskedCell) -> TraceOut:
    kit = Kit(asked.module, {"seed": SEED})
    return _traced(sandbox, _Program(asked.code.encode(), CELL, None, (), {}, kit, drawing=True))


def _call(sandbox: Sandbox, asked: AskedCall) -> TraceOut:
    call = calls.read(asked.call)
    kit = _kit(_definition(asked.exercise).kit(stream(SEED, "kit")), asked.library)
    return _traced(
        sandbox, _Program(asked.source, FILENAME, call.function, call.arguments, call.named, kit, calls.written(call))
    )


def _replay(sandbox: Sandbox, asked: AskedReplay) -> TraceOut:
    definition = _definition(asked.exercise)
    hurried = replace(
        asked.policy,
        cpu_seconds=min(asked.policy.cpu_seconds, replaying.LONGEST),
        wall_seconds=min(asked.policy.wall_seconds, replaying.LONGEST),
    )
    library = [one.shelf() for one in asked.library]
    programs = SandboxPrograms(sandbox, hurried, library)
    case = replaying.find(definition, asked.check, asked.inputs, asked.source, programs, seed=asked.seed)
    if case is None:
        return _untraced(
            asked.source, FILENAME, ProgramFault(FaultKind.RUNTIME_ERROR, trace_messages.NOT_THE_SAME), cut=True
        )
    call = calls.Call(case.function, case.arguments, {})
    kit = _kit(case.kit, asked.library)
    program = _Program(asked.source, FILENAME, case.function, case.arguments, {}, kit, calls.written(call))
    brief = replace(hurried, cpu_seconds=marks.LONGEST, wall_seconds=marks.LONGEST)
    tried = SandboxPrograms(sandbox, brief, library)
    mark = marks.of(definition, asked.mistakes, asked.source, asked.check, tried, seed=asked.seed)
    return _traced(sandbox, program, before=case.reply, mark=mark)


def _definition(exercise: str) -> CodeDefinition:
    definition = discovery.find(exercise)
    assert isinstance(definition, CodeDefinition), "only exercises of code are asked about"
    return definition


def _kit(settings: KitSettings, library: tuple[Earlier, ...]) -> Kit:
    return Kit(settings.module, dict(settings.parameters), settings.without, tuple(one.shelf() for one in library))


def _traced(
    sandbox: Sandbox, program: _Program, *, before: Reply | None = None, mark: MarkOut | None = None
) -> TraceOut:
    """`before` is what the same call has returned among the others."""
    waits = program.function is None
    try:
        session = sandbox.open(
            program.source,
            kit=program.kit,
            policy=POLICY,
            filename=program.filename,
            drawing=program.drawing,
            echo_last=waits,
            deferred=waits,
        )
    except ProgramFault as unloaded:
        trace = _untraced(program.source, program.filename, unloaded)
        return trace.model_copy(update={"call": program.call, "stdout": visible(unloaded.stdout)})
    with session:
        followed = session.trace(program.function, *program.arguments, named=program.named)
    told = Told(len(_lines(program.source)))
    end, reply = understood(told, followed, waits=waits)
    left_out = trace_messages.left_out(told.left, truncated=session.stdout_truncated)
    if before is not None and end.kind == "returned" and not (reply and same_value(before.value, reply[0])):
        left_out.append(trace_messages.ANSWERED_OTHERWISE)
    return TraceOut(
        lines=_lines(program.source),
        filename=program.filename,
        call=program.call,
        frames=told.frames,
        steps=told.steps,
        end=end,
        left_out=left_out,
        stdout=visible(session.stdout()),
        mark=mark,
        milliseconds=0,
    )


def understood(told: Told, followed: TraceResult, *, waits: bool) -> tuple[EndOut, tuple[Value, ...]]:
    """Reads the steps; how it ended, and what came back where it could be sent."""
    fault = followed.fault
    try:
        told.read(followed.steps)
        if fault is None:
            return _returned(followed.value, waits=waits)
    except Malformed:
        fault = ProgramFault(FaultKind.INVALID_OUTPUT, trace_messages.FORGED)
    if fault.kind == FaultKind.TIMEOUT and trace_messages.given_up(told.left):
        return EndOut(kind="cut", title=trace_messages.CUT, message=trace_messages.NOT_ENDED), ()
    return _faulty(fault), ()


def _returned(answer: Value, *, waits: bool) -> tuple[EndOut, tuple[Value, ...]]:
    match answer:
        case (described, tuple() as reply) if len(reply) < 2:
            value = values.read(described)
            if len(value.model_dump_json().encode()) <= VALUE:
                return EndOut(kind="returned", value=None if waits else value), reply
    raise Malformed("no answer of a tracer")


def _faulty(fault: ProgramFault) -> EndOut:
    title = Outcome(fault.kind.value).wording().title
    return EndOut(kind="fault", title=title, message=fault.message, line=fault.line)


def _untraced(source: bytes, filename: str, fault: ProgramFault, *, cut: bool = False) -> TraceOut:
    """Nothing was followed, and why."""
    end = EndOut(kind="cut", title=trace_messages.NOT_FOUND, message=fault.message) if cut else _faulty(fault)
    return TraceOut(
        lines=_lines(source),
        filename=filename,
        call="",
        frames=[],
        steps=[],
        end=end,
        left_out=[],
        stdout="",
        mark=None,
        milliseconds=0,
    )


def _lines(source: bytes) -> list[str]:
    """As the interpreter counts them."""
    return [visible(line) for line in re.split("\r\n|\r|\n", source.decode("utf-8-sig", "replace"))]
