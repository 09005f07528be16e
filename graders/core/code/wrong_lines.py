"""The lines of a hunted program that make it wrong: those by which it differs from a right one in the same form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

from graders.core.code.folder import MODEL
from graders.core.code.hunts import CodeExercise, Hunt, extract_imports
from graders.core.code.student_form import rewrite_as_student_form

#: Lines of one mistake, at most, for which one asks; one that is spread wider has no line.
MAX_WRONG_LINES = 2


@dataclass(frozen=True)
class ChangedLines:
    """The wrong lines of a program by their numbers, from 1 on, each with the line that mends it."""

    mending: Mapping[int, str]

    def mend(self, program: str) -> str:
        """Return the program with its wrong lines replaced."""
        lines = program.splitlines()
        return "".join(f"{self.mending.get(number, line)}\n" for number, line in enumerate(lines, 1))


def find_wrong_lines(exercise: CodeExercise, hunt: Hunt, seed: int, public: Sequence[str]) -> ChangedLines | None:
    """Return the wrong lines of a hunt's program in the form of a seed.

    The exercise's model is a right program of which the catalogue's mistakes are edits. None where the mistake is no
    edit of it, or takes, adds or changes more than a line or two.
    """
    path = exercise.folder / MODEL
    if hunt.misconception.whole or not path.exists():
        return None
    model = f"{extract_imports(exercise.solution)}{path.read_text(encoding='utf-8')}"
    right = rewrite_as_student_form(model, hunt.function, seed, public=public).splitlines()
    wrong = hunt.wrong_program_source(seed, public).splitlines()
    mending: dict[int, str] = {}
    for kind, start, end, first, last in SequenceMatcher(None, right, wrong, autojunk=False).get_opcodes():
        if kind != "equal" and end - start != last - first:
            return None
        if kind != "equal":
            mending |= {first + k + 1: right[start + k] for k in range(last - first)}
    return ChangedLines(mending) if 0 < len(mending) <= MAX_WRONG_LINES else None
