"""The corpus of programs that attack the trusted side: each gets its outcome, at a cost bounded by the live policy.

A program of `tests/hostile/juge` defines ``repondre``, which stands for functions of an exercise, and finds the limits
of the policy in ``LIMITES``. It is filed by the outcome of the whole submission. Memory, processor time and
weight are those of this process, which reads, compares, simplifies, diagnoses and puts in words what the program gives.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import pytest

from graders.core.contract.bounds import VERDICT_BYTES, json_size, limit_size
from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Blame, Outcome
from graders.core.contract.verdict import Verdict
from server.course import Course, Exercise
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox
from tests.support.service import EXERCISE

CORPUS = Path(__file__).resolve().parents[1] / "hostile" / "juge"
PROGRAMS = sorted(CORPUS.glob("*/*.py"))
SEED = 7
#: Bytes in memory for each byte of the answer that is read, of all that were read, for each item: a byte may become a
#: complex number while it is read, then a float that a check keeps and subtracts from others, an item a small array.
PER_BYTE_READ, PER_BYTE_KEPT, PER_ITEM = 16, 12, 200


@dataclass
class Cost:
    """What a grading took of this process: seconds of processor, bytes beyond those that it began with."""

    seconds: float = 0.0
    memory: int = 0


@contextmanager
def costed() -> Iterator[Cost]:
    cost = Cost()
    Path("/proc/self/clear_refs").write_text("5")  # the peak is counted from here
    begun, resident = time.process_time(), _status("VmRSS")
    yield cost
    cost.seconds, cost.memory = time.process_time() - begun, _status("VmHWM") - resident


def _status(name: str) -> int:
    lines = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return 1024 * int(lines[name].split()[0])


def attacking(exercise: Exercise, program: Path, functions: Sequence[str]) -> bytes:
    """The solution, but for these functions."""
    limits = {name: value for name, value in asdict(exercise.policy).items() if isinstance(value, int)}
    attack = program.read_text(encoding="utf-8")
    return f"LIMITES = {limits}\n{exercise.solution}\n{attack}\n{' = '.join(functions)} = repondre\n".encode()


@pytest.fixture(scope="module")
def grader(course: Course, course_sandbox: Sandbox) -> SandboxGrader:
    return SandboxGrader(course, course_sandbox)


@cache
def rehearsed(exercise: Exercise) -> Exercise:
    """What is imported at first use costs no submission."""
    exercise.grader.warm_up()
    return exercise


def judged(grader: SandboxGrader, exercise: Exercise, source: bytes) -> tuple[Judgement, Cost]:
    with costed() as cost:
        found = grader.grade(exercise.id, source, SEED)
        recorded = limit_size(found)
        assert Verdict.from_json(json.loads(json.dumps(recorded.verdict.to_json()))) == recorded.verdict
    return recorded, cost


def assert_affordable(exercise: Exercise, recorded: Judgement, cost: Cost) -> None:
    policy = exercise.policy
    assert json_size(recorded.verdict.to_json()) + json_size(recorded.figures) <= VERDICT_BYTES
    assert cost.seconds <= policy.judging_seconds
    most = PER_BYTE_READ * policy.frame_bytes + PER_BYTE_KEPT * policy.session_bytes
    assert cost.memory <= most + PER_ITEM * policy.session_items


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_program_that_attacks_the_judge_gets_its_outcome_at_a_bounded_cost(
    grader: SandboxGrader, course: Course, program: Path
) -> None:
    """What one function does costs the others nothing."""
    exercise = rehearsed(course.exercises[EXERCISE])
    recorded, cost = judged(grader, exercise, attacking(exercise, program, ["relatif"]))
    assert recorded.verdict.outcome == program.parent.name
    right = {check.id for check in recorded.verdict.checks if check.passed}
    assert right - {"arguments"} == {"composer_exemples", "composer_hasard", "composer_tours", "inverse"}
    assert all(check.message for check in recorded.verdict.checks if not check.passed)
    assert_affordable(exercise, recorded, cost)


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_whatever_the_exercise(grader: SandboxGrader, course: Course, program: Path) -> None:
    for exercise in course.exercises.values():
        if exercise.kind == "code":
            functions = [function.name for function in exercise.functions]
            recorded, cost = judged(grader, rehearsed(exercise), attacking(exercise, program, functions))
            assert recorded.verdict.outcome.blame is Blame.STUDENT
    assert_affordable(exercise, recorded, cost)


def test_the_judge_is_none_the_worse(grader: SandboxGrader, course: Course) -> None:
    exercise = course.exercises[EXERCISE]
    assert grader.grade(EXERCISE, exercise.solution.encode(), SEED).verdict.outcome is Outcome.OK


def test_the_corpus_is_there() -> None:
    assert len(PROGRAMS) >= 25
    assert {path.parent.name for path in PROGRAMS} >= {"output_limit", "invalid_output", "wrong_answer"}
