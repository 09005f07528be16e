"""Advice on right programs: followed, it gives a program that passes; a program that needs none gets none."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path

import pytest

import graders
from graders import discovery
from graders.core.advice import trying
from graders.core.advice.remarks import list_advice
from graders.core.advice.ways import choose_diverse_specimens, strip_docstrings_and_comments
from graders.core.code.exercise import CodeDefinition
from graders.core.code.grading import CodeGrader
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from server.course import Course

SQUARES = "def norme(v):\n    total = 0.0\n    for x in v:\n        total += x * x\n    return total ** 0.5\n"
FILL = "def f(v):\n    out = 0 * v\n    for i in range(len(v)):\n        out[i] = math.cos(v[i]) + 2\n    return out\n"
LIST = "def f(v):\n    r = []\n    for x, y in v:\n        r.append([x + y, x * y])\n    return np.array(r)\n"
HOIST = "def f(a, v):\n    s = 0\n    while s < 3:\n        s += np.cos(a)  # tourne\n    return s\n"
CASES = {
    "sum": (SQUARES, "total += np.sum(v * v)"),
    "fill": (FILL, "out[:] = np.cos(v) + 2"),
    "list": (LIST, "r = np.stack([v[:, 0] + v[:, 1], v[:, 0] * v[:, 1]], axis=-1)"),
    "hoist": (HOIST, "cosinus_a = np.cos(a)"),
    "copy": ("def f(a):\n    b = np.array(np.zeros(3))\n    return b + a\n", "b = np.zeros(3)"),
    "name": ("def f(a):\n    sum = a[0] + a[1]\n    return sum\n", "somme = a[0] + a[1]"),
    "inverse": ("def f(A, b):\n    return np.linalg.inv(A) @ b\n", "return np.linalg.solve(A, b)"),
}
NOTHING = {
    "order": "def f(v):\n    s = 0\n    for x in v:\n        s += s * x\n    return s\n",
    "break": "def f(v):\n    s = 0\n    for x in v:\n        if x > 3:\n            break\n        s += x\n",
    "random": "def f(n):\n    s = 0\n    while s < n:\n        s += rng.normal(0, 1)\n    return s\n",
    "changed": "def f(p):\n    for k in range(9):\n        avance(p)\n        x = np.linalg.norm(p)\n    return x\n",
    "broken": "def f(:\n",
}


@pytest.mark.parametrize("name", CASES)
def test_what_can_be_written_otherwise_is_told_with_its_line(name: str) -> None:
    source, line = CASES[name]
    [advice] = list_advice(source, ["f", "norme"], "")
    assert line in advice.after
    assert advice.source.splitlines()[advice.line - 1].strip() in advice.after
    compile(advice.source, "x", "exec")


@pytest.mark.parametrize("name", NOTHING)
def test_what_must_stay_is_left_alone(name: str) -> None:
    assert not list(list_advice(NOTHING[name], ["f"], ""))


def advised(exercises: str) -> Iterator[tuple[CodeDefinition, Path]]:
    for folder in sorted(Path(graders.__file__).parent.glob(f"{exercises}/specimens/ok")):
        definition = discovery.load_definition("/".join(folder.parts[-4:-2]))
        if isinstance(definition, CodeDefinition) and not definition.long and not definition.heavy:
            for path in sorted(folder.glob("*.py")):
                if any(list_advice(path.read_text(), (), definition.solution)):
                    yield definition, path


@pytest.mark.parametrize(
    "exercises", ["l20/calibration", "l20/reechantillonnage", pytest.param("l*/*", marks=pytest.mark.slow)]
)
def test_followed_advice_gives_a_program_that_passes(
    course: Course, exercises: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trying, "MIN_GAIN", 0.0)  # what was slower here passes too
    followed = 0
    for definition, path in advised(exercises):
        with redirect_stdout(io.StringIO()):
            review = trying.review_program(definition, path.read_text(), LOCAL)
        for tried in review.advice:
            grader = course.exercises["/".join(path.parts[-5:-3])].grader
            assert isinstance(grader, CodeGrader)
            verdict = grader.grade(tried.advice.source.encode(), LOCAL, seed=7, version="").verdict
            assert verdict.outcome is Outcome.OK, (path, tried.advice.after)
            followed += 1
    assert followed


def test_the_other_ways_differ_most() -> None:
    loop, vector, same = SQUARES, "def norme(v):\n    return np.sqrt(np.sum(v ** 2))\n", SQUARES.replace("total", "t")
    assert choose_diverse_specimens(loop, {"same": same, "vector": vector}, 1) == ["vector"]


def test_a_way_is_shown_without_what_its_author_wrote_for_authors() -> None:
    body = 'import math  # why\n\n\ndef f(a):\n    """Return."""\n    # a comment\n    return "#" + a\n'
    source = f'\ufeff"""An English word."""\n\n{body}'
    assert strip_docstrings_and_comments(source) == 'import math\n\n\ndef f(a):\n    return "#" + a\n'
    alone = 'class A:\n    """Nothing else."""\n'
    assert strip_docstrings_and_comments(alone) == alone


def test_the_ways_of_the_course_run_without_their_remarks() -> None:
    for path in sorted(Path(graders.__file__).parent.glob("l20/poses/specimens/ok/*.py")):
        text = strip_docstrings_and_comments(path.read_text(encoding="utf-8"))
        compile(text, path.name, "exec")
        assert '"""' not in text
