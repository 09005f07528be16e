"""One run of a cell: in the sandbox, with the kit, to what its page shows."""

from __future__ import annotations

import base64
import re
import time
from contextlib import suppress
from dataclasses import dataclass

from graders.core.contract.outcomes import Outcome
from server.cells import png
from server.cells.schemas import CellFault, CellRunResult
from server.sandbox import FaultKind, Frame, Kit, Policy, ProgramFault, Sandbox, SandboxFault, Session
from server.sandbox.install import import_set_of
from server.text.plain import show_invisible_characters

KIB, MIB = 1 << 10, 1 << 20
FILENAME = "cellule.py"
#: A cell gives the same numbers each time that it is run: what changes comes from what was changed in it.
SEED = 20
POLICY = Policy(
    cpu_seconds=3.0,
    wall_seconds=6.0,
    memory_bytes=256 * MIB,
    stdout_bytes=32 * KIB,
    frame_bytes=5 * MIB,
    source_bytes=64 * KIB,
    file_bytes=1 * MIB,
    folder_bytes=4 * MIB,
    items=1000,
)
#: What the sandbox says to the author of an exercise, and what a cell's reader is told instead.
_MESSAGE_REPLACEMENTS = (
    (r"\s: tout arrive par les arguments", ""),
    (r"Rien ne se trace pendant l’évaluation.*", "Pour tracer, importez «\u202fmatplotlib.pyplot\u202f»."),
)
UNREADABLE = "Une figure ne peut pas être lue : dessinez-la avec les fonctions de matplotlib, et laissez-la ouverte."


@dataclass(frozen=True)
class _CellOutput:
    stdout: str
    truncated: bool
    figures: tuple[bytes, ...] = ()
    fault: ProgramFault | None = None


def run_cell(sandbox: Sandbox, kit: str, source: bytes) -> CellRunResult:
    """Raises SandboxFault when the fault is ours, and nothing else. The time told is without a template's start."""
    with suppress(SandboxFault):  # opening a session tries again, and tells
        sandbox.warm(import_set_of(source, drawing=True))
    start = time.monotonic()
    shown = _execute_cell(sandbox, kit, source)
    return CellRunResult(
        stdout=show_invisible_characters(shown.stdout),
        truncated=shown.truncated,
        fault=_describe_fault(shown.fault) if shown.fault else None,
        figures=["data:image/png;base64," + base64.b64encode(picture).decode() for picture in shown.figures],
        milliseconds=round(1000 * (time.monotonic() - start)),
    )


def _execute_cell(sandbox: Sandbox, kit: str, source: bytes) -> _CellOutput:
    settings = Kit(kit, {"seed": SEED})
    try:
        session = sandbox.open(source, kit=settings, policy=POLICY, filename=FILENAME, drawing=True, echo_last=True)
    except ProgramFault as unloaded:
        return _CellOutput(unloaded.stdout, unloaded.stdout_truncated, fault=unloaded)
    figures, fault = _collect_figures(session)
    return _CellOutput(session.stdout(), session.stdout_truncated, figures, fault)


def _collect_figures(session: Session) -> tuple[tuple[bytes, ...], ProgramFault | None]:
    """Pictures of our own making, or why there are none; ends the session."""
    try:
        with session:
            given = session.figures()
        return tuple(png.reencode_png(file) for file in given), None
    except ProgramFault as fault:
        return (), fault
    except png.MalformedPng:
        return (), ProgramFault(FaultKind.INVALID_OUTPUT, UNREADABLE)


def _describe_fault(fault: ProgramFault) -> CellFault:
    title = Outcome(fault.kind.value).wording().title
    message = fault.message
    for pattern, instead in _MESSAGE_REPLACEMENTS:
        message = re.sub(pattern, instead, message)
    return CellFault(
        title=title, message=message, line=fault.line, frames=[_format_frame(frame) for frame in fault.frames]
    )


def _format_frame(frame: Frame) -> str:
    inside = "" if frame.function.startswith("<") else f", dans {frame.function}"
    return f"ligne {frame.line}{inside} : {frame.source.strip()}"
