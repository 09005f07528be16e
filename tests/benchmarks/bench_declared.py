"""The verdict of a declared exercise by that of a packaged one of the same size: same functions, same calls.

    PYTHONPATH=. python tests/benchmarks/bench_declared.py [--rounds 60]

The packaged exercise is re-declared: its solution, and the calls that its checks make of a right program. A right
program is sent to both in turn, then one with a known mistake, which is named.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from graders.core.code.grading import CodeGrader
from graders.core.contract.local import LOCAL
from graders.core.contract.program import Answer, Block, KitSettings, PlannedCalls, Program, Reply
from graders.core.contract.values import Arguments, Value
from graders.core.declared.declaration import MAX_CASES, MAX_CHECKS, read_declaration
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.scenario_values import value_text
from server.course import load_course
from server.grading.sandbox_grader import SandboxGrader, SandboxPrograms
from server.sandbox import Sandbox
from server.studio.authored import POLICY
from tests.benchmarks.measure import Goal, Row, figure, median

EXERCISE, SEED, REST = "l20/odometrie", 5, 0.03
AT_MOST = Goal(2)


class Recorder:
    """Starts programs in this process, and records the calls that checks make of them."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, Arguments]] = []

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        return _Recorded(LOCAL.open(source, kit, ahead), self.calls)


class _Recorded:
    def __init__(self, program: Program, calls: list[tuple[str, Arguments]]) -> None:
        self._program, self._calls = program, calls

    @property
    def functions(self) -> frozenset[str]:
        return self._program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        self._calls.append((function, args))
        return self._program.call(function, *args, return_arguments=return_arguments)

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        recorded = list(calls)
        self._calls += [(function, args) for args in recorded]
        return self._program.call_many(function, recorded, faults=faults)

    def call_batches(self, asked: Sequence[PlannedCalls]) -> Iterator[Block]:
        batches = [replace(each, calls=list(each.calls)) for each in asked]
        self._calls += [(each.function, args) for each in batches for args in each.calls]
        return self._program.call_batches(batches)

    def stdout(self) -> str:
        return self._program.stdout()

    def close(self) -> None:
        self._program.close()


def redeclare(packaged: CodeGrader) -> tuple[DeclaredGrader, int]:
    """Return the exercise as a declared one, and the number of its calls."""
    recorder = Recorder()
    packaged.grade(packaged.solution.encode(), recorder, seed=SEED, version="")
    texts = [f"{name}({', '.join(map(_text, args))})" for name, args in recorder.calls][: MAX_CASES * MAX_CHECKS]
    parts = [texts[start : start + MAX_CASES] for start in range(0, len(texts), MAX_CASES)]
    checks = [
        {"id": f"v{k}", "titre": f"v{k}", "points": 20.0 / len(parts), "cas": part, "tolerance": 1e-6}
        for k, part in enumerate(parts)
    ]
    mistake = packaged.misconceptions[0]
    declared = {
        "fonctions": list(packaged.functions),
        "solution": packaged.solution,
        "verifications": checks,
        "erreurs": [
            {"id": "connue", "titre": "t", "explication": "e", "question": "", "programme": _imports(packaged, mistake)}
        ],
    }
    return DeclaredGrader("l20/essai_222222", read_declaration(declared)), len(texts)


def _imports(packaged: CodeGrader, mistake: object) -> str:
    return f"import numpy as np\n{getattr(mistake, 'source', '')}"


def _text(value: Value) -> str:
    return f"np.{value_text(value, None)}" if isinstance(value, np.ndarray) else value_text(value, None)


def rows(rounds: int) -> list[Row]:
    course = load_course()
    packaged = course.exercises[EXERCISE].grader
    assert isinstance(packaged, CodeGrader)
    declared, calls = redeclare(packaged)
    made = []
    with Sandbox(course.kits) as sandbox:
        grader = SandboxGrader(course, sandbox)
        for words, source, right in (
            ("right", packaged.solution, True),
            ("wrong and named", _imports(packaged, packaged.misconceptions[0]), False),
        ):
            pairs = [_pair(grader, declared, sandbox, source.encode(), right=right) for _ in range(rounds + 3)][3:]
            of_packaged, of_declared = (median([pair[k] for pair in pairs]) for k in (0, 1))
            subject = f"`{EXERCISE}` re-declared, {calls} calls, {words}"
            made.append(Row(subject, "ms", of_declared, limit=of_packaged))
            made.append(Row(f"{subject} ÷ packaged", "×", of_declared / of_packaged, goal=AT_MOST))
    return made


def _pair(
    grader: SandboxGrader, declared: DeclaredGrader, sandbox: Sandbox, source: bytes, *, right: bool
) -> tuple[float, float]:
    """Return the milliseconds of a verdict of the packaged exercise, then of the declared one."""
    taken = []
    for submit in (
        lambda: grader.grade(EXERCISE, source, SEED).verdict,
        lambda: (
            declared.grade(
                source, SandboxPrograms(sandbox, POLICY, asked=declared.functions), seed=SEED, version="1"
            ).verdict
        ),
    ):
        time.sleep(REST)
        started = time.perf_counter()
        verdict = submit()
        taken.append(1000 * (time.perf_counter() - started))
        if (verdict.score == 1) != right or (not right and verdict.diagnosis is None):
            raise RuntimeError(f"{verdict.score}, {verdict.diagnosis}")
    return taken[0], taken[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--rounds", type=int, default=60)
    for row in rows(parser.parse_args().rounds):
        print(row.subject, figure(row.measured or 0.0), row.unit)


if __name__ == "__main__":
    main()
