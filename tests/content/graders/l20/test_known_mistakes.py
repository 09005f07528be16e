"""Every mistake that the catalogues know, in each way that they know of it, gets one mark whatever the seed.

But for what a program's own draws decide: a filter that is wrong gets now and then through a check on what it drew. In
exercises with closed loops such checks may differ, no other.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from graders.core.code.checks import Check, Trial
from graders.core.code.grading import CodeGrader
from graders.core.code.loops import ClosedLoop
from graders.core.code.runner import Runner
from graders.core.code.running import run_checks
from graders.core.compare.shrinking import Budget
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.streams import stream
from tests.support.quick import some
from tests.support.shipped import CODE

pytestmark = pytest.mark.slow

SEEDS = range(2026, 2032)
#: What is shown of a mistake is not looked at: counterexamples are left as they are found.
AS_FOUND = Budget(calls=0)
#: Checks that look at what a filter drew by itself.
OF_DRAWS = (Trial, ClosedLoop)
#: Specimens that a program of this process can be, which neither raises at once nor has to be stopped.
RUNNING = (Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT, Outcome.RUNTIME_ERROR)


def known(grader: CodeGrader) -> Iterator[tuple[str, str]]:
    """The wrong programs of an exercise, each with its name: edits of the model, whole programs, specimens."""
    if grader.prober is not None:
        model = grader.prober.model
        for edit in model.edits:
            yield from ((edit.id, mutant.text) for mutant in model.combine([next(model.correct_versions())], [edit]))
    yield from ((mistake.id, mistake.source) for mistake in grader.misconceptions if mistake.whole)
    for specimen in grader.specimens():
        if specimen.outcome in RUNNING:
            yield specimen.path.name, specimen.path.read_text(encoding="utf-8")


def failed(grader: CodeGrader, source: str, seed: int) -> frozenset[str]:
    """The ids of the checks that fail."""
    kit = grader.kit(stream(seed, "kit"))
    runner = Runner(LOCAL, source.encode(), kit, budget=AS_FOUND)
    findings = run_checks(grader.checks, runner, kit, seed)
    runner.close()
    return frozenset(finding.result.id for finding in findings if not finding.passed)


def points(checks: tuple[Check, ...], failed: frozenset[str]) -> float:
    """Without those of the checks that look at what a program drew."""
    drawing = OF_DRAWS if any(isinstance(check, ClosedLoop) for check in checks) else ()
    return sum(check.points for check in checks if check.id not in failed and not isinstance(check, drawing))


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # mistakes divide by zero, and overflow
@pytest.mark.parametrize("exercise", sorted(CODE))
def test_a_known_mistake_gets_one_mark_whatever_the_seed(exercise: str) -> None:
    grader = CODE[exercise]
    varying, accepted = {}, []
    for name, source in some(known(grader)):
        found = {seed: failed(grader, source, seed) for seed in SEEDS}
        if len({points(grader.checks, ids) for ids in found.values()}) > 1:
            varying[name, source] = found
        if not all(found.values()):
            accepted.append((name, source))
    assert not varying
    assert not accepted
