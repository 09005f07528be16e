"""What every grader's folder defines, whatever the kind of its exercise."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

MODULE_FILE = "grader.py"


@dataclass(frozen=True)
class Definition:
    """An exercise as its grader's folder describes it. It grades once the course has bound it to what it says of it."""

    folder: Path

    @property
    def exercise(self) -> str:
        """Its name, which its place gives: "l20/poses" for graders/l20/poses."""
        return f"{self.folder.parent.name}/{self.folder.name}"

    @property
    def file(self) -> Path:
        """Where what is wrong in it is told."""
        return self.folder / MODULE_FILE
