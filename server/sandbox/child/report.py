"""Reports an exception of the child as bounded plain values, which the trusted side turns into French."""

from __future__ import annotations

import errno
import os
import re
from types import CodeType, TracebackType
from typing import Any

import numpy as np

from .codec import Value

MAX_TEXT, MAX_NAME, MAX_FRAMES, MAX_SOURCE, MAX_VALUES = 600, 80, 8, 200, 5
MAX_INT = 10**15
_NAME = re.compile(r"(?<![\w.'\"])([^\W\d]\w{0,40})(\.T\b)?(?![\w(])")
_PART = re.compile(r"\[[\d:,\s-]{1,30}\]")
#: System limits that a program can meet without trying to escape: descriptors, a full folder, a file too big.
_LIMITS = (errno.EMFILE, errno.ENFILE, errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
#: Libraries whose own system errors mean that a wall refused something.
_REACHING_OUT = ("socket", "subprocess", "multiprocessing", "urllib", "ssl", "asyncio", "http", "ctypes")


def describe_fault(error: BaseException, filename: str, lines: list[str]) -> dict[str, Value]:
    """Fields of a fault: kind, exception, text, line, frames (line, function, source), module."""
    frames = _student_file_frames(error.__traceback__, filename, lines)
    return {
        "kind": _fault_kind(error),
        "exception": type(error).__name__[:MAX_NAME],
        "text": _exception_text(error),
        "line": frames[-1][0] if frames else None,
        "frames": tuple(frames),
        "detail": _guilty_name_or_path(error, filename, lines),
    }


def describe_syntax_fault(error: BaseException, lines: list[str]) -> dict[str, Value]:
    """Fields of a fault of the file itself; `detail` is the offending text."""
    line = error.lineno if isinstance(error, SyntaxError) else None
    has_line = isinstance(line, int) and 0 < line <= len(lines)
    source = lines[line - 1].strip()[:MAX_TEXT] if has_line and line else ""
    message = error.msg if isinstance(error, SyntaxError) else _exception_text(error)
    return {
        "kind": "memory_limit" if isinstance(error, MemoryError) else "syntax_error",
        "exception": type(error).__name__[:MAX_NAME],
        "text": str(message)[:MAX_TEXT],
        "line": line if has_line else None,
        "frames": (),
        "detail": source,
    }


def _exception_text(error: BaseException) -> str:
    try:
        text = str(error)[:MAX_TEXT]
    except BaseException as failure:  # a student's __str__ may raise anything, and that changes nothing
        return f"<{type(failure).__name__[:MAX_NAME]}>"
    return text


def student_file_lines(traceback: TracebackType | None, filename: str) -> list[int]:
    """Return the lines of the file in a traceback, outermost first."""
    lines = []
    while traceback is not None:
        if traceback.tb_frame.f_code.co_filename == filename:
            lines.append(traceback.tb_lineno)
        traceback = traceback.tb_next
    return lines


def _student_file_frames(
    traceback: TracebackType | None, filename: str, lines: list[str]
) -> list[tuple[int, str, str]]:
    frames: list[tuple[int, str, str]] = []
    while traceback is not None:
        code = traceback.tb_frame.f_code
        if code.co_filename == filename:
            frames.append(describe_frame(code, traceback.tb_lineno, lines))
            if len(frames) > MAX_FRAMES:
                del frames[2]  # the way in, then the last ones: what a deep recursion needs
        traceback = traceback.tb_next
    return frames


def describe_frame(code: CodeType, line: int | None, lines: list[str]) -> tuple[int, str, str]:
    """Line, function and source of a frame: where it is called there is no line yet, and its first one is told."""
    line = line or code.co_firstlineno
    source = lines[line - 1].strip()[:MAX_SOURCE] if 0 < line <= len(lines) else ""
    return line, code.co_name[:MAX_NAME], source


def _innermost_module(traceback: TracebackType | None) -> str:
    name = ""
    while traceback is not None:
        name = str(traceback.tb_frame.f_globals.get("__name__", ""))
        traceback = traceback.tb_next
    return name.partition(".")[0]


def _fault_kind(error: BaseException) -> str:
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return "memory_limit"
    if isinstance(error, ImportError) and _innermost_module(error.__traceback__) != "multiprocessing":
        return "import_error"
    return "forbidden_operation" if _is_refused_by_wall(error) else "runtime_error"


def _is_refused_by_wall(error: BaseException) -> bool:
    """Whether a wall refused what the program tried: a permission, a path out of its folder, a connection."""
    if isinstance(error, RuntimeError) and "start new thread" in _exception_text(error):
        return True
    if not isinstance(error, (OSError, ImportError)):
        return False
    number = getattr(error, "errno", None)
    if isinstance(error, PermissionError) or number in (errno.EPERM, errno.EACCES, errno.EROFS):
        return True
    if number in _LIMITS:
        return False
    reaching = {_innermost_module(error.__traceback__), type(error).__module__.partition(".")[0]}
    return _is_outside_folder(getattr(error, "filename", None)) or not reaching.isdisjoint(_REACHING_OUT)


def _is_outside_folder(path: object) -> bool:
    if isinstance(path, bytes):
        path = os.fsdecode(path)
    return isinstance(path, str) and (path.startswith(("/", "~")) or ".." in path.split("/"))


def _guilty_name_or_path(error: BaseException, filename: str, lines: list[str]) -> str:
    """The name or the path at the heart of the matter, or what the names on the guilty line of the file are."""
    if isinstance(error, (TypeError, ValueError, IndexError)) and not isinstance(error, UnicodeError):
        return _values_on_line(error.__traceback__, filename, lines)
    for attribute in ("name", "filename"):
        value = getattr(error, attribute, None)
        if isinstance(value, str):
            return value[:200]
    if isinstance(error, SystemExit):
        return _exception_text(error)
    return ""


def _values_on_line(traceback: TracebackType | None, filename: str, lines: list[str]) -> str:
    """What the first names on the line where the file failed are, in French: numbers, and the shapes of arrays.

    Only exact types of Python and numpy are looked at: no code of the student runs.
    """
    innermost = None
    while traceback is not None:
        if traceback.tb_frame.f_code.co_filename == filename:
            innermost = traceback
        traceback = traceback.tb_next
    if innermost is None or not 0 < innermost.tb_lineno <= len(lines):
        return ""
    frame = innermost.tb_frame
    described: dict[str, str] = {}
    for match in _NAME.finditer(lines[innermost.tb_lineno - 1]):
        name, transposed = match.group(1), match.group(2) or ""
        value = frame.f_locals.get(name, frame.f_globals.get(name))
        part = "" if transposed else _subscript_after_name(value, lines[innermost.tb_lineno - 1][match.end() :])
        words = (
            _describe_value_in_french(_select_element(value, part), "")
            if part
            else _describe_value_in_french(value, transposed)
        )
        if words and len(described) < MAX_VALUES:
            described[name + transposed + part] = words
    return ", ".join(f"{name} {words}" for name, words in described.items())[:MAX_TEXT]


def _subscript_after_name(value: Any, after: str) -> str:
    """Return the part of a value that a line reads behind its name, « [:2] »; empty where it has none."""
    match = _PART.match(after)
    return match[0] if match and _select_element(value, match[0]) is not None else ""


def _select_element(value: Any, part: str) -> Any:
    """Return a part of an array, a list or a tuple, given by numbers: « [:, 0] »; None where there is none."""
    if type(value) not in (np.ndarray, list, tuple):
        return None
    try:
        keys = [
            slice(*(int(bound) if bound.strip() else None for bound in piece.split(":")))
            if ":" in piece
            else int(piece)
            for piece in part[1:-1].split(",")
        ]
        return value[keys[0] if len(keys) == 1 else tuple(keys)]
    except (ValueError, IndexError, TypeError):
        return None


def _describe_value_in_french(value: Any, transposed: str) -> str:
    kind, words = type(value), ""
    if kind is np.ndarray:
        words = f"est un tableau de forme {value.shape[::-1] if transposed else value.shape}"
    elif transposed:
        words = ""
    elif kind in (float, np.float64):
        words = "vaut " + f"{value:.6g}".replace(".", ",").replace("-", "\u2212")
    elif kind is int and abs(value) < MAX_INT:
        words = f"vaut {value}"
    elif kind is str:
        words = "est une cha\u00eene de caract\u00e8res"
    elif kind in (list, tuple):
        words = f"est {'une liste' if kind is list else 'un tuple'} de longueur {len(value)}"
    return words
