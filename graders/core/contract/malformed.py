"""What an author's mistake raises."""

from __future__ import annotations

from pathlib import Path


class MalformedExerciseError(Exception):
    """A grader's folder that does not hold together: where (path, line) and why."""

    def __init__(self, path: Path, message: str, line: int = 1) -> None:
        super().__init__(f"{path}:{line}: {message}")
        self.path, self.message, self.line = path, message, line
