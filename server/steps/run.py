"""Traces one program in the sandbox, with the kit of its grading, and builds the trace that the page shows."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

from graders import discovery
from graders.core.code.exercise import CodeDefinition
from graders.core.contract.kits import SCENARIOS
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, Reply
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments, same_value
from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.scenarios import Scenario, Statement
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import FaultKind, Kit, Policy, ProgramFault, Sandbox, TraceResult, Value
from server.steps import calls, marks, replaying, trace_messages, values
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
from server.steps.schemas import EndOut, MarkOut, TraceOut
from server.steps.trace_reader import MAX_VALUE_BYTES, TraceReader
from server.steps.values import MalformedTrace
from server.text.plain import show_invisible_characters

KIB, MIB = 1 << 10, 1 << 20
FILENAME, CELL = "solution.py", "cellule.py"
#: Seed of typed calls and of cells, so that each run gives the same trace.
SEED = 20
#: Limits of a traced program. An answer is one step; the tracer has lower bounds of its own.
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
class _TracedProgram:
    """A source, the call to trace (None: its top level), its kit, and the call as text.

    `driven`: a driver plays the call, and returns no value of the program. `plain`: the steps are not wanted.
    """

    source: bytes
    filename: str
    function: str | None
    arguments: Arguments
    named: Mapping[str, Value]
    kit: Kit
    call: str = ""
    drawing: bool = False
    driven: bool = False
    plain: bool = False


def trace_question(sandbox: Sandbox, question: TraceQuestion) -> TraceOut:
    """Trace the requested program. Raises SandboxFault, or any exception of a grader, when the fault is ours."""
    start = time.monotonic()
    trace = _trace_request(sandbox, question.steps)
    return trace.model_copy(update={"milliseconds": round(1000 * (time.monotonic() - start))})


def _trace_request(sandbox: Sandbox, request: TraceRequest) -> TraceOut:
    match request:
        case CellTraceRequest():
            return _trace_cell(sandbox, request)
        case CallTraceRequest():
            return _trace_call(sandbox, request)
        case ReplayTraceRequest():
            return _trace_replay(sandbox, request)
        case ScenarioTraceRequest():
            return _trace_scenario(sandbox, request)
        case ProgramRunRequest():
            return _trace_whole_program(sandbox, request)


def _trace_cell(sandbox: Sandbox, request: CellTraceRequest) -> TraceOut:
    kit = Kit(request.module, {"seed": SEED})
    return _trace_program(sandbox, _TracedProgram(request.code.encode(), CELL, None, (), {}, kit, drawing=True))


def _trace_call(sandbox: Sandbox, request: CallTraceRequest) -> TraceOut:
    settings = (
        KitSettings(SCENARIOS, {"seed": SEED})
        if request.is_declared
        else _find_definition(request.exercise).kit(stream(SEED, "kit"))
    )
    kit = _make_kit(settings, request.library)
    if request.plain and not request.call.strip():
        source = request.source + (f"\n{request.after}".encode() if request.after.strip() else b"")
        trace = _trace_program(sandbox, _TracedProgram(source, FILENAME, None, (), {}, kit, plain=True))
        return _relocate_fault_in_small_program(trace, len(_split_lines(request.source)))
    call = calls.parse_call(request.call)
    program = _TracedProgram(
        request.source, FILENAME, call.function, call.arguments, call.named, kit, calls.format_call(call)
    )
    return _trace_program(sandbox, replace(program, plain=request.plain))


def _relocate_fault_in_small_program(trace: TraceOut, lines: int) -> TraceOut:
    """Return a trace whose fault behind the `lines` of the file is told by its place in the small program."""
    end = trace.end
    if end.line is None or end.line <= lines:
        return trace
    title = f"{end.title}, ligne {end.line - lines} du petit programme"
    return trace.model_copy(update={"end": end.model_copy(update={"title": title, "line": None})})


def _trace_replay(sandbox: Sandbox, request: ReplayTraceRequest) -> TraceOut:
    definition = _find_definition(request.exercise)
    tight = replace(
        request.policy,
        cpu_seconds=min(request.policy.cpu_seconds, replaying.MAX_SECONDS),
        wall_seconds=min(request.policy.wall_seconds, replaying.MAX_SECONDS),
    )
    library = [file.to_file() for file in request.library]
    programs = SandboxPrograms(sandbox, tight, library)
    case = replaying.find_replay_case(
        definition, request.check, request.inputs, request.source, programs, seed=request.seed
    )
    if case is None:
        return _empty_trace(
            request.source, FILENAME, ProgramFault(FaultKind.RUNTIME_ERROR, trace_messages.NOT_THE_SAME), cut=True
        )
    call = calls.TypedCall(case.function, case.arguments, {})
    kit = _make_kit(case.kit, request.library)
    program = _TracedProgram(request.source, FILENAME, case.function, case.arguments, {}, kit, calls.format_call(call))
    brief = replace(tight, cpu_seconds=marks.MAX_SECONDS, wall_seconds=marks.MAX_SECONDS)
    repairs = SandboxPrograms(sandbox, brief, library)
    mark = marks.locate_mistake(definition, request.mistakes, request.source, request.check, repairs, seed=request.seed)
    return _trace_program(sandbox, program, before=case.reply, mark=mark)


def _trace_scenario(sandbox: Sandbox, request: ScenarioTraceRequest) -> TraceOut:
    """Trace a case of a declared exercise. Its driver returns what all steps gave: each return tells its own value."""
    scenario = Scenario(
        parse_scenario(request.case, request.functions, imports=request.imports), request.lines, request.files
    )
    kit = Kit(SCENARIOS, dict(request.kit))
    return _trace_program(
        sandbox,
        _TracedProgram(
            request.source,
            FILENAME,
            scenario.called_program_name,
            scenario.driver_arguments(),
            {},
            kit,
            scenario.text(),
            driven=True,
        ),
    )


def _trace_whole_program(sandbox: Sandbox, request: ProgramRunRequest) -> TraceOut:
    """Run a whole program as its grading does. What its prompts show and what they read is part of what it prints."""
    played = Scenario((Statement("program", callee=request.function, arguments=request.lines),))
    kit = Kit(SCENARIOS, dict(request.kit))
    program = _TracedProgram(
        request.source, FILENAME, request.function, played.driver_arguments(), {}, kit, driven=True, plain=True
    )
    return _trace_program(sandbox, program)


def _find_definition(exercise: str) -> CodeDefinition:
    definition = discovery.load_definition(exercise)
    assert isinstance(definition, CodeDefinition), "only exercises of code are request about"
    return definition


def _make_kit(settings: KitSettings, library: tuple[LibraryFileData, ...]) -> Kit:
    return Kit(settings.module, dict(settings.parameters), settings.without, tuple(file.to_file() for file in library))


def _trace_program(
    sandbox: Sandbox, program: _TracedProgram, *, before: Reply | None = None, mark: MarkOut | None = None
) -> TraceOut:
    """Trace a program; `before` is the reply of the same call during the grading."""
    is_top_level = program.function is None
    try:
        session = sandbox.open(
            program.source,
            kit=program.kit,
            policy=POLICY,
            filename=program.filename,
            drawing=program.drawing,
            echo_last=is_top_level,
            deferred=is_top_level,
        )
    except ProgramFault as unloaded:
        trace = _empty_trace(program.source, program.filename, unloaded)
        return trace.model_copy(update={"call": program.call, "stdout": show_invisible_characters(unloaded.stdout)})
    with session:
        result = session.trace(program.function, *program.arguments, named=program.named)
    reader = TraceReader(len(_split_lines(program.source)))
    end, reply = read_trace_result(reader, result, shows_value=not (is_top_level or program.driven))
    if program.plain:
        reader.frames, reader.steps, reader.omissions = [], [], []
        end = _end_of_fault(result.fault) if result.fault and end.kind == "cut" else end
        if program.driven and (name := _find_own_exception(reply)):
            end = _end_of_fault(ProgramFault(FaultKind.RUNTIME_ERROR, trace_messages.OWN_EXCEPTION.format(name=name)))
    omissions = trace_messages.list_omission_messages(reader.omissions, truncated=session.stdout_truncated)
    if before is not None and end.kind == "returned" and not (reply and same_value(before.value, reply[0])):
        omissions.append(trace_messages.ANSWERED_OTHERWISE)
    return TraceOut(
        lines=_split_lines(program.source),
        filename=program.filename,
        call=program.call,
        frames=reader.frames,
        steps=reader.steps,
        end=end,
        left_out=omissions,
        stdout=show_invisible_characters(session.stdout()),
        mark=mark,
        milliseconds=0,
    )


def read_trace_result(
    reader: TraceReader, result: TraceResult, *, shows_value: bool
) -> tuple[EndOut, tuple[Value, ...]]:
    """Read the steps; return the end, and the returned value in a tuple where it could be sent."""
    fault = result.fault
    try:
        reader.read_records(result.steps)
        if fault is None:
            return _read_returned_value(result.value, shows_value=shows_value)
    except MalformedTrace:
        fault = ProgramFault(FaultKind.INVALID_OUTPUT, trace_messages.FORGED)
    if fault.kind == FaultKind.TIMEOUT and trace_messages.was_tracing_stopped(reader.omissions):
        return EndOut(kind="cut", title=trace_messages.CUT, message=trace_messages.NOT_ENDED), ()
    return _end_of_fault(fault), ()


def _find_own_exception(reply: tuple[Value, ...]) -> str:
    """Return the name of the exception of the student's own class that ended a played program, or an empty string."""
    match reply:
        case ([*_, ("e", [str(name), *_])],) | (([*_, ("e", [str(name), *_])], str(), *_),):
            return show_invisible_characters(name)
    return ""


def _read_returned_value(answer: Value, *, shows_value: bool) -> tuple[EndOut, tuple[Value, ...]]:
    match answer:
        case (described, tuple() as reply) if len(reply) < 2:
            value = values.read_value(described)
            if len(value.model_dump_json().encode()) <= MAX_VALUE_BYTES:
                return EndOut(kind="returned", value=value if shows_value else None), reply
    raise MalformedTrace("no answer of a tracer")


def _end_of_fault(fault: ProgramFault) -> EndOut:
    title = Outcome(fault.kind.value).wording().title
    return EndOut(kind="fault", title=title, message=fault.message, line=fault.line)


def _empty_trace(source: bytes, filename: str, fault: ProgramFault, *, cut: bool = False) -> TraceOut:
    """Return a trace without steps that says why."""
    end = EndOut(kind="cut", title=trace_messages.NOT_FOUND, message=fault.message) if cut else _end_of_fault(fault)
    return TraceOut(
        lines=_split_lines(source),
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


def _split_lines(source: bytes) -> list[str]:
    """Split into lines as the interpreter counts them."""
    return [show_invisible_characters(line) for line in re.split("\r\n|\r|\n", source.decode("utf-8-sig", "replace"))]
