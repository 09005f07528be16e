"""Running of an exercise's checks on one program, and their findings in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.code.runner import Runner
from graders.core.code.simplifying import PendingShrink, run_and_shrink, shrink_all
from graders.core.compare.slips import SLIPS
from graders.core.compare.told_apart import remove_noise_from_pair
from graders.core.compare.words import to_complete_jsonable, to_jsonable
from graders.core.contract.findings import Finding
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, PlannedCalls, StudentFault
from graders.core.contract.streams import stream
from graders.core.contract.verdict import CheckResult, Counterexample

FIGURE_ITEMS = 20_000


def run_checks(
    checks: Sequence[Check],
    runner: Runner,
    kit: KitSettings,
    seed: int,
    *,
    launches_if_failed: Callable[[], int] = lambda: 0,
    calls_if_failed: Callable[[Sequence[Check]], Sequence[PlannedCalls]] = lambda failed: (),
) -> list[Finding]:
    """Return the finding of each check on the runner's program; the same draws for the same seed.

    `launches_if_failed` gives the further launches to announce at the first failure; `calls_if_failed`, the batches to
    piggyback on the exchanges that shrink counterexamples.
    """
    benches = [Bench(check.id, runner, stream(seed, check.id), kit) for check in checks]
    results: list[Finding | PendingShrink] = []
    for begins, ends in _group_checks_by_exchange(checks):
        plan = _plan_calls(checks[begins:ends], benches[begins:ends])
        if begins:
            runner.set_plan(plan)
        else:
            try:
                runner.start(plan)
            except StudentFault as fault:
                return [make_failed_finding(check, fault_rejection(fault, inputs=None)) for check in checks]
            runner.announce_launches(sum(check.launches for check in checks))
        for check, bench in zip(checks[begins:ends], benches[begins:ends], strict=True):
            results.append(_run_without_shrinking(check, bench))
            if isinstance(results[-1], PendingShrink) or not results[-1].passed:
                if not runner.failed:
                    runner.announce_launches(launches_if_failed())
                runner.failed.add(check.id)
    if runner.failed:
        runner.queue_piggyback_calls(calls_if_failed([check for check in checks if check.id in runner.failed]))
    if failed := [result for result in results if isinstance(result, PendingShrink)]:
        runner.freeze_stdout()
        shrink_all(runner, failed, runner.answer_batches)
    findings = [
        _shrink_finding(check, result, bench) if isinstance(result, PendingShrink) else result
        for check, result, bench in zip(checks, results, benches, strict=True)
    ]
    return [
        _remove_unearned_points(check, finding, checks, findings)
        for check, finding in zip(checks, findings, strict=True)
    ]


def _group_checks_by_exchange(checks: Sequence[Check]) -> Iterator[tuple[int, int]]:
    """Yield ranges of checks whose planned calls can be sent together: only the last has unplanned calls."""
    begins = 0
    for ends, check in enumerate(checks, 1):
        if check.has_unplanned_calls or ends == len(checks):
            yield begins, ends
            begins = ends


def _plan_calls(checks: Sequence[Check], benches: Sequence[Bench]) -> Sequence[PlannedCalls]:
    for check, bench in zip(checks, benches, strict=True):
        bench.planned_calls = check.planned_calls(bench)
    return [batch for bench in benches for batch in bench.planned_calls]


def _remove_unearned_points(
    check: Check, finding: Finding, checks: Sequence[Check], findings: Sequence[Finding]
) -> Finding:
    """Take back the points of a check that any do-nothing function passes, when nothing else was earned."""
    others = [
        f
        for c, f in zip(checks, findings, strict=True)
        if not c.requires_other_check and set(c.functions) & set(check.functions)
    ]
    if not check.requires_other_check or not finding.passed or any(f.passed for f in others):
        return finding
    message = "Rien à reprocher ici, mais ces points ne comptent qu'à partir d'une autre vérification réussie."
    got = "aucune pour l'instant"
    return make_failed_finding(
        check, Rejection(message, inputs={}, expected="une autre vérification réussie", got=got, neutral=True)
    )


def run_check(check: Check, bench: Bench) -> Finding:
    """Run one check, with shrinking, and return its finding."""
    return _run_and_catch_finding(check, lambda: run_and_shrink(check.run, bench), bench)


def _run_without_shrinking(check: Check, bench: Bench) -> Finding | PendingShrink:
    """Run one check; return its finding, or the pending shrink of its counterexample."""
    try:
        return _run_and_catch_finding(check, lambda: check.run(bench), bench)
    except PendingShrink as unsimplified:
        return unsimplified


def _shrink_finding(check: Check, unsimplified: PendingShrink, bench: Bench) -> Finding:
    """Return the finding of a failed check on the simplest input that was found."""

    def raise_rejection() -> None:
        raise unsimplified.rejection()

    return _run_and_catch_finding(check, raise_rejection, bench)


def _run_and_catch_finding(check: Check, run: Callable[[], None], bench: Bench) -> Finding:
    try:
        run()
    except Rejection as rejection:
        rejection.kit = bench.side_kit
        return make_failed_finding(check, rejection)
    except StudentFault as fault:
        inputs = None
        if bench.last_call is not None:
            inputs = {f"argument {i + 1}": value for i, value in enumerate(bench.last_call[1])}
        return make_failed_finding(check, fault_rejection(fault, inputs=inputs))
    return Finding(CheckResult(check.id, check.title, True, check.points, check.points, bench.measured))


def make_failed_finding(check: Check, rejection: Rejection) -> Finding:
    """Return the finding of a check that this rejection fails."""
    counterexample = None
    if rejection.inputs is not None:
        inputs = {name: to_jsonable(value) for name, value in rejection.inputs.items()}
        shown = remove_noise_from_pair(to_jsonable(rejection.expected), to_jsonable(rejection.got))
        counterexample = Counterexample(inputs, *shown)
    # A drawing of a part would be a drawing of something else.
    figure = None if rejection.figure is None else to_complete_jsonable(rejection.figure, limit=FIGURE_ITEMS)
    result = CheckResult(
        id=check.id,
        title=check.title,
        passed=False,
        points=0,
        max_points=check.points,
        message=rejection.message,
        counterexample=counterexample,
        hint=_hint_of_failure(check, rejection),
        figure=None if figure is None else check.id,
        cause=None if rejection.cause is Outcome.WRONG_ANSWER else rejection.cause,
        neutral=rejection.neutral,
        kit=_side_program_json(rejection.kit),
    )
    return Finding(result, rejection.cause, rejection.slip, figure, rejection.sign)


def _side_program_json(kit: KitSettings | None) -> dict[str, Any] | None:
    """Return as JSON the map, range and seed of a side program; None for the main one, whose seed tells them."""
    if kit is None or "libres" not in kit.parameters:
        return None
    settings: dict[str, Any] | None = to_complete_jsonable(dict(kit.parameters), limit=MAX_KIT_ITEMS)
    return settings


#: Cells of a map, and other settings of a kit, that a verdict holds.
MAX_KIT_ITEMS = 2000
_OF_UNREADABLE = "Que renvoie exactement votre fonction, et de quelle forme l'énoncé le demande-t-il ?"
#: Slips that say more of a failure than the hint of its check, which is about right numbers.
TELLING_SLIPS = ("nan", "forme", "scalaire", "transposee", "entiers", "hasard", "memoire")


def _hint_of_failure(check: Check, rejection: Rejection) -> str | None:
    """Return the question that this kind of failure calls for; None for a program that stops, or without a fault."""
    if rejection.neutral or rejection.cause not in (Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT):
        return None
    if rejection.cause is Outcome.INVALID_OUTPUT:
        return _OF_UNREADABLE
    return SLIPS[rejection.slip].question if rejection.slip in TELLING_SLIPS else check.hint
