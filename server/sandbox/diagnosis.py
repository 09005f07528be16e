"""Turns a child's report, or the way it died, into the fault of a student's program."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable, Sequence
from typing import Any

from server.sandbox import messages
from server.sandbox.child.report import MAX_FRAMES, MAX_NAME, MAX_SOURCE, MAX_TEXT
from server.sandbox.faults import FaultKind, Frame, ProgramFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import ChildExit

_KILLED_BY_TIME = (signal.SIGXCPU, signal.SIGALRM, signal.SIGPROF)
_CHILD_FAULT_KINDS = frozenset(FaultKind) - {FaultKind.MISSING_FUNCTION}
_MAX_LINE = 10**6
_LENGTHS = {"exception": MAX_NAME, "text": MAX_TEXT, "detail": MAX_TEXT}
#: Below this share of its memory limit, a killed program did not run out of memory.
_OOM_SHARE = 0.25
_FRAME_LINE = re.compile(rf'^  File "(.+)", line (\d{{1,7}}) in (.{{1,{MAX_NAME}}})$', re.MULTILINE)


def forged_answer_fault() -> ProgramFault:
    return _fatal_fault(FaultKind.INVALID_OUTPUT, messages.forged())


def answers_too_big_fault(what: str, policy: Policy) -> ProgramFault:
    """Return the fault of a session whose answers are too big together; `what` is bytes or items."""
    return _fatal_fault(FaultKind.OUTPUT_LIMIT, messages.answers_too_big(what, policy))


def wall_timeout_fault(policy: Policy, frames: tuple[Frame, ...] = ()) -> ProgramFault:
    return _timeout_fault("wall", policy, frames)


def _fatal_fault(kind: FaultKind, message: str) -> ProgramFault:
    return ProgramFault(kind, messages.add_no_break_spaces(message), fatal=True)


def _timeout_fault(what: str, policy: Policy, frames: tuple[Frame, ...]) -> ProgramFault:
    line = frames[-1].line if frames else None
    message = messages.add_no_break_spaces(messages.timeout(what, policy, line, frames))
    return ProgramFault(FaultKind.TIMEOUT, message, line=line, frames=frames, fatal=True)


def parse_last_frames(words: str, filename: str, lines: Sequence[str]) -> tuple[Frame, ...]:
    """Return the frames of the student's file in a crash traceback (innermost first); none if there is none.

    The student's process wrote it: only line numbers and bounded names are taken from it.
    """
    frames = []
    for entry in _FRAME_LINE.finditer(words):
        line = int(entry[2])
        if entry[1] == filename and 0 < line <= len(lines):
            frames.append(
                Frame(
                    line,
                    messages.remove_control_characters(_decode_name_escapes(entry[3])),
                    messages.remove_control_characters(lines[line - 1].strip()),
                )
            )
    return tuple(reversed(frames[:MAX_FRAMES]))


def _decode_name_escapes(name: str) -> str:
    """Decode the escapes by which the interpreter writes non-ASCII letters of a name."""
    return re.sub(r"\\x([0-9a-f]{2})|\\u([0-9a-f]{4})", lambda escape: chr(int(escape[1] or escape[2], 16)), name)


def exit_fault(ending: ChildExit, policy: Policy, frames: tuple[Frame, ...] = ()) -> ProgramFault:
    """Return the fault of a program that died without an answer and that we did not kill; `frames`: its last position.

    Raises TemplateFault for a program killed from outside: it cannot send itself SIGKILL, and had not taken the
    memory for which the kernel would have sent it.
    """
    if os.WIFEXITED(ending.status):
        return _fatal_fault(FaultKind.RUNTIME_ERROR, messages.exited(os.WEXITSTATUS(ending.status)))
    number = os.WTERMSIG(ending.status)
    if number == signal.SIGSYS:
        return _fatal_fault(FaultKind.FORBIDDEN_OPERATION, messages.forbidden("appel système", None, ()))
    if ending.out_of_memory:
        return _fatal_fault(FaultKind.MEMORY_LIMIT, messages.memory_limit(policy, None, ()))
    exhausted = number == signal.SIGKILL and ending.cpu_seconds >= policy.cpu_seconds
    if number in _KILLED_BY_TIME or exhausted:
        return _timeout_fault("cpu", policy, frames)
    if number == signal.SIGKILL and ending.max_rss_bytes < policy.memory_bytes * _OOM_SHARE:
        raise TemplateFault("a child was killed from outside")
    if number == signal.SIGKILL:  # the kernel's own answer to a lack of memory
        return _fatal_fault(FaultKind.MEMORY_LIMIT, messages.memory_limit(policy, None, ()))
    return _fatal_fault(FaultKind.RUNTIME_ERROR, messages.killed_by_signal(number))


def parse_fault(fault: Any, policy: Policy, file_lines: Sequence[str] = ()) -> ProgramFault | None:
    """Parse the fault that a child reported for a file of these lines; None when it does not have the form of one."""
    if not isinstance(fault, dict) or set(fault) != {"kind", "exception", "text", "line", "frames", "detail"}:
        return None
    kind, line, frames = fault["kind"], fault["line"], _parse_frames(fault["frames"])
    if not isinstance(kind, str) or kind not in _CHILD_FAULT_KINDS or frames is None:
        return None
    if not _is_line(line):  # an honest program may be where there is none: that is no forgery
        line = None
    if not all(_is_text(fault[name], longest) for name, longest in _LENGTHS.items()):
        return None
    exception, text, detail = (messages.remove_control_characters(fault[name]) for name in _LENGTHS)
    message = _fault_message(FaultKind(kind), exception, text, detail, line, frames, policy, file_lines)
    return ProgramFault(
        FaultKind(kind),
        messages.add_no_break_spaces(message),
        line=line,
        frames=frames,
        exception=exception or None,
        fatal=kind == FaultKind.TIMEOUT,
    )


def _is_line(line: object) -> bool:
    return type(line) is int and 0 < line < _MAX_LINE


def _is_text(text: object, longest: int) -> bool:
    """Whether it is a text of at most `longest` characters: a child of ours sends no longer one."""
    return isinstance(text, str) and len(text) <= longest


def _parse_frames(reported: object) -> tuple[Frame, ...] | None:
    """Parse the frames that have a line; None when they do not have the form of frames."""
    if not isinstance(reported, tuple) or len(reported) > MAX_FRAMES:
        return None
    frames = []
    for entry in reported:
        if not isinstance(entry, tuple) or len(entry) != 3:
            return None
        line, function, source = entry
        if not (_is_text(function, MAX_NAME) and _is_text(source, MAX_SOURCE)):
            return None
        if _is_line(line):
            frames.append(
                Frame(line, messages.remove_control_characters(function), messages.remove_control_characters(source))
            )
    return tuple(frames)


def _fault_message(
    kind: FaultKind,
    exception: str,
    text: str,
    detail: str,
    line: int | None,
    frames: tuple[Frame, ...],
    policy: Policy,
    file_lines: Sequence[str],
) -> str:
    """Return the French sentence of a reported fault; `detail` depends on the kind (see `child.report`)."""
    of_result = not exception and detail.count("|") >= 2
    sentences: dict[FaultKind, Callable[[], str]] = {
        FaultKind.SYNTAX_ERROR: lambda: messages.syntax_error(text, detail, line, file_lines),
        FaultKind.IMPORT_ERROR: lambda: messages.import_error(exception, detail, text, line, frames),
        FaultKind.TIMEOUT: lambda: messages.timeout(detail, policy, line, frames),
        FaultKind.MEMORY_LIMIT: lambda: messages.memory_limit(policy, line, frames),
        FaultKind.FORBIDDEN_OPERATION: lambda: messages.forbidden(text, line, frames),
    }
    if kind in sentences:
        return sentences[kind]()
    if of_result:
        return _result_message(kind, text, detail, policy)
    return messages.runtime_error(exception or "Erreur", text, line, frames, detail, file_lines)


def _result_message(kind: FaultKind, culprit: str, detail: str, policy: Policy) -> str:
    reason, where, function = detail.split("|", 2)
    if kind == FaultKind.OUTPUT_LIMIT:
        return messages.answer_too_big(reason, function, policy)
    return messages.not_a_value(reason, culprit, where, function, policy)
