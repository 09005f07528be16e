"""Honest variety: at least fifteen right programs an exercise, in styles that differ, and none of them ever refused."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from graders.core.code.grading import CodeGrader
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from tests.support.quick import some
from tests.support.shipped import CODE

LEAST = 15
#: A chain of stages, each of which is an exercise with styles of its own.
CHAINS = {"l20/tp_slam": 2}
SEEDS = range(30)
#: Where one grading takes seconds: closed loops of many runs, large graphs.
FEWER = {"l20/mcl": range(4), "l20/defi_kidnappe": range(2), "l20/defi_robuste": range(10)}


def honest(grader: CodeGrader) -> list[Path]:
    return [specimen.path for specimen in grader.specimens() if specimen.outcome is Outcome.OK]


def shape(source: str) -> str:
    """A program without its comments, its texts and its choice of names: two that share it are one program."""
    names: dict[str, str] = {}

    def anonymous(found: re.Match[str]) -> str:
        return names.setdefault(found[0], f"'{len(names)}'")

    return re.sub(r"'[^'\\]*(?:\\.[^'\\]*)*'", anonymous, ast.dump(ast.parse(source)))


def read(path: Path) -> str:
    """As it stands, but for the kit: in this process it is not a module that can be imported."""
    source = path.read_text(encoding="utf-8-sig")
    return re.sub(r"^from l20 import (.+)$", lambda line: _bound(line[1]), source, flags=re.MULTILINE)


def _bound(imported: str) -> str:
    pairs = [name.split(" as ") for name in imported.split(", ")]
    return "; ".join(f"{pair[-1]} = {pair[0]}" for pair in pairs if pair[0] != pair[-1]) or "pass"


@pytest.mark.parametrize("exercise", CODE)
def test_there_are_fifteen_right_programs_that_differ(exercise: str) -> None:
    grader = CODE[exercise]
    shapes = {path.name: shape(path.read_text(encoding="utf-8-sig")) for path in honest(grader)}
    assert len(shapes) >= CHAINS.get(grader.exercise, LEAST)
    assert len({*shapes.values(), shape(grader.solution)}) == len(shapes) + 1


def test_a_program_whose_names_are_changed_is_no_other_style() -> None:
    one = "def f(a, b):\n    return a + b  # ici\n"
    assert shape(one) == shape("def g(x, y):\n    return x + y\n")
    assert shape(one) != shape("def f(a, b):\n    return b + a\n")


@pytest.mark.slow
@pytest.mark.parametrize("exercise", CODE)
def test_no_right_program_is_ever_refused(exercise: str) -> None:
    grader = CODE[exercise]
    for path in some(honest(grader)):
        for seed in FEWER.get(exercise, SEEDS):
            assert grader.first_failed_check(read(path).encode(), LOCAL, seed=seed) is None, f"{path.stem}, seed {seed}"
