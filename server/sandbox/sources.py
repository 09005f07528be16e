"""What a source needs before it is opened: that it is text, and the libraries that its processes import."""

from __future__ import annotations

from server.sandbox import messages
from server.sandbox.faults import FaultKind, ProgramFault
from server.sandbox.foreign_files import describe_foreign_file
from server.sandbox.install import import_set_of
from server.sandbox.piled_marks import find_piled_marks
from server.sandbox.policy import Policy
from server.sandbox.values import LIBRARY_MENTION, Kit


def import_set_of_program(source: bytes, kit: Kit | None, *, drawing: bool = False) -> str:
    """Return the import set of a program: the smallest that its source and earlier files need."""
    earlier = kit.own_files if kit is not None and LIBRARY_MENTION in source else ()
    return import_set_of(b"".join((source, *(file.source for file in earlier))), drawing=drawing)


def import_set_of_course(kit: Kit) -> str:
    """Return the import set of the process that holds the course's functions."""
    return import_set_of(b"".join(file.source for file in kit.sealed_files))


def may_call_course(source: bytes, kit: Kit) -> bool:
    """Whether a program is likely to have functions of the course called."""
    return bool(kit.course_functions) and LIBRARY_MENTION in source


def require_text(source: bytes, policy: Policy, *, cell: bool = False) -> None:
    """Raise ProgramFault for a source that is too big, or no text of a program; a `cell` may be a value alone."""
    if len(source) > policy.source_bytes:
        message = messages.source_too_big(len(source), policy)
        raise ProgramFault(FaultKind.SYNTAX_ERROR, messages.add_no_break_spaces(message), fatal=True)
    if not cell and (foreign := describe_foreign_file(source)):
        raise ProgramFault(
            FaultKind.SYNTAX_ERROR, messages.add_no_break_spaces(foreign), exception="SyntaxError", fatal=True
        )
    if (piled := find_piled_marks(source)) is not None:
        message = messages.unreadable_line(messages.piled_marks(), piled)
        raise ProgramFault(
            FaultKind.SYNTAX_ERROR,
            messages.add_no_break_spaces(message),
            line=piled,
            exception="SyntaxError",
            fatal=True,
        )
    if b"\0" in source:
        line = source[: source.index(b"\0")].count(b"\n") + 1
        message = messages.unreadable_line(messages.null_byte(), line)
        raise ProgramFault(
            FaultKind.SYNTAX_ERROR,
            messages.add_no_break_spaces(message),
            line=line,
            exception="SyntaxError",
            fatal=True,
        )
