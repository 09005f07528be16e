"""The error raised for an author's mistake."""

from __future__ import annotations

from pathlib import Path


class MalformedExerciseError(Exception):
    """A grader's folder is inconsistent: where (path, line) and why."""

    def __init__(self, path: Path, message: str, line: int = 1) -> None:
        super().__init__(f"{path}:{line}: {message}")
        self.path, self.message, self.line = path, message, line
