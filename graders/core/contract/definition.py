"""The definition that every grader's folder exports, for any kind of exercise."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

MODULE_FILE = "grader.py"


@dataclass(frozen=True)
class Definition:
    """An exercise as its grader's folder describes it; the course binds it to its texts, which gives a grader."""

    folder: Path

    @property
    def exercise(self) -> str:
        """Its name, from its folder: "l20/poses" for graders/l20/poses."""
        return f"{self.folder.parent.name}/{self.folder.name}"

    @property
    def file(self) -> Path:
        """The file to which its errors are attributed."""
        return self.folder / MODULE_FILE
