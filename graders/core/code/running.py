"""Running the checks of an exercise on one program: what each of them finds, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.code.runner import Runner
from graders.core.code.simplifying import PendingShrink, run_and_shrink, shrink_all
from graders.core.compare.words import tidy, to_jsonable, whole_jsonable
from graders.core.contract.findings import Finding
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
    beside: Callable[[Sequence[Check]], Sequence[PlannedCalls]] = lambda failed: (),
) -> list[Finding]:
    """What each of the checks finds of the runner's program, with the same draws for the same seed.

    Once one has failed, the file is about to be started so many times more. What is asked `beside` of the same program,
    once it is known which checks have failed, goes with what simplifies these.
    """
    benches = [Bench(check.id, runner, stream(seed, check.id), kit) for check in checks]
    found: list[Finding | PendingShrink] = []
    for begins, ends in _spans(checks):
        plan = _foreseen(checks[begins:ends], benches[begins:ends])
        if begins:
            runner.plan(plan)
        else:
            try:
                runner.start(plan)
            except StudentFault as fault:
                return [_finding(check, fault_rejection(fault, inputs=None)) for check in checks]
            runner.announce_launches(sum(check.launches for check in checks))
        for check, bench in zip(checks[begins:ends], benches[begins:ends], strict=True):
            found.append(_found(check, bench))
            if isinstance(found[-1], PendingShrink) or not found[-1].passed:
                if not runner.failed:
                    runner.announce_launches(launches_if_failed())
                runner.failed.add(check.id)
    if runner.failed:
        runner.piggyback(beside([check for check in checks if check.id in runner.failed]))
    if failed := [one for one in found if isinstance(one, PendingShrink)]:
        runner.freeze_stdout()
        shrink_all(runner, failed, runner.answer_batches)
    findings = [
        _told(check, one, bench) if isinstance(one, PendingShrink) else one
        for check, one, bench in zip(checks, found, benches, strict=True)
    ]
    return [_unless_alone(check, finding, checks, findings) for check, finding in zip(checks, findings, strict=True)]


def _spans(checks: Sequence[Check]) -> Iterator[tuple[int, int]]:
    """Checks in a row whose questions can go together: none but the last asks more than what is foreseen of it."""
    begins = 0
    for ends, check in enumerate(checks, 1):
        if check.has_unplanned_calls or ends == len(checks):
            yield begins, ends
            begins = ends


def _foreseen(checks: Sequence[Check], benches: Sequence[Bench]) -> Sequence[PlannedCalls]:
    for check, bench in zip(checks, benches, strict=True):
        bench.planned_calls = check.planned_calls(bench)
    return [asked for bench in benches for asked in bench.planned_calls]


def _unless_alone(check: Check, finding: Finding, checks: Sequence[Check], findings: Sequence[Finding]) -> Finding:
    """Take back the points of a check that any do-nothing function passes, when nothing else was earned."""
    others = [
        f
        for c, f in zip(checks, findings, strict=True)
        if not c.requires_other_check and set(c.functions) & set(check.functions)
    ]
    if not check.requires_other_check or not finding.passed or any(f.passed for f in others):
        return finding
    message = "Rien à reprocher ici, mais ces points ne comptent qu'à partir d'une autre vérification réussie."
    return _finding(
        check, Rejection(message, inputs={}, expected="une autre vérification réussie", got="aucune pour l'instant")
    )


def run_check(check: Check, bench: Bench) -> Finding:
    """Run one check and put what it found in words."""
    return _judged(check, lambda: run_and_shrink(check.run, bench), bench)


def _found(check: Check, bench: Bench) -> Finding | PendingShrink:
    """As `run_check`, of one that does not simplify what it fails on."""
    try:
        return _judged(check, lambda: check.run(bench), bench)
    except PendingShrink as unsimplified:
        return unsimplified


def _told(check: Check, unsimplified: PendingShrink, bench: Bench) -> Finding:
    """What a check that has failed holds against the program, on the simplest input that was found."""

    def tell() -> None:
        raise unsimplified.rejection()

    return _judged(check, tell, bench)


def _judged(check: Check, run: Callable[[], None], bench: Bench) -> Finding:
    try:
        run()
    except Rejection as rejection:
        return _finding(check, rejection)
    except StudentFault as fault:
        inputs = None
        if bench.last_call is not None:
            inputs = {f"argument {i + 1}": value for i, value in enumerate(bench.last_call[1])}
        return _finding(check, fault_rejection(fault, inputs=inputs))
    return Finding(CheckResult(check.id, check.title, True, check.points, check.points))


def _finding(check: Check, rejection: Rejection) -> Finding:
    counterexample = None
    if rejection.inputs is not None:
        inputs = {name: to_jsonable(value) for name, value in rejection.inputs.items()}
        counterexample = Counterexample(inputs, tidy(to_jsonable(rejection.expected)), tidy(to_jsonable(rejection.got)))
    # A drawing of a part would be a drawing of something else.
    figure = None if rejection.figure is None else whole_jsonable(rejection.figure, limit=FIGURE_ITEMS)
    result = CheckResult(
        id=check.id,
        title=check.title,
        passed=False,
        points=0,
        max_points=check.points,
        message=rejection.message,
        counterexample=counterexample,
        hint=check.hint,
        figure=None if figure is None else check.id,
    )
    return Finding(result, rejection.cause, rejection.slip, figure)
