"""Faults by responsibility: `ProgramFault` is the student's, `SandboxFault` is ours."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class FaultKind(StrEnum):
    SYNTAX_ERROR = "syntax_error"
    IMPORT_ERROR = "import_error"
    MISSING_FUNCTION = "missing_function"
    RUNTIME_ERROR = "runtime_error"
    TIMEOUT = "timeout"
    MEMORY_LIMIT = "memory_limit"
    OUTPUT_LIMIT = "output_limit"
    FORBIDDEN_OPERATION = "forbidden_operation"
    INVALID_OUTPUT = "invalid_output"


@dataclass(frozen=True)
class Frame:
    """One level of the student's own file in a traceback."""

    line: int
    function: str
    source: str


class ProgramFault(Exception):
    """A fault of the student's program.

    `message` is French and addressed to the student; `exception` is the name of the Python exception, if there was one;
    `fatal` means that the process is gone and the session can only be closed. A file that does not load leaves no
    session: `stdout` holds its output.
    """

    stdout = ""
    stdout_truncated = False

    def __init__(
        self,
        kind: FaultKind,
        message: str,
        *,
        line: int | None = None,
        frames: tuple[Frame, ...] = (),
        exception: str | None = None,
        fatal: bool = False,
    ) -> None:
        super().__init__(f"{kind}: {message}")
        self.kind, self.message, self.line = kind, message, line
        self.frames, self.exception, self.fatal = frames, exception, fatal


class SandboxFault(Exception):
    """The sandbox itself failed; never the student's fault. The pool has already tried twice."""


class TemplateFault(Exception):
    """A template or a fork failed before any line of the student ran: worth another try with a new template."""


class NamespacesRefused(TemplateFault):
    """This machine refuses the namespaces to this user: the other walls must stand alone."""
