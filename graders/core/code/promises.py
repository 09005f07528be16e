"""Whether the checks of an exercise ask what its contracts promise: the forms of arguments, the edges judged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from graders.core.code.contracts import FunctionContract
from graders.core.code.grading import CodeGrader
from graders.core.code.recording import CallRecorder
from graders.core.contract.values import Arguments, Value

#: Calls of one function that are looked at, on each map.
MAX_CALLS = 5000
#: The seeds of two gradings: what both ask is asked whatever the seed.
SEEDS = (1, 2)

Calls = Mapping[str, Mapping[bytes, Arguments]]


def find_broken_promises(grader: CodeGrader) -> Iterator[str]:
    """Yield, in French, each promise that the checks do not keep. Grades the solution twice in this process."""
    if not grader.contracts:
        return
    calls, others = (recorded_calls(grader, seed) for seed in SEEDS)
    for contract in grader.contracts:
        yield from _iter_broken_promises(contract, calls[contract.function], others[contract.function])


def recorded_calls(grader: CodeGrader, seed: int) -> Calls:
    """Return the calls that a grading of the solution makes, by function and by their arguments."""
    recorder = CallRecorder(grader.functions, MAX_CALLS)
    grader.first_failed_check(grader.solution.encode(), recorder, seed=seed)
    found: dict[str, dict[bytes, Arguments]] = {name: {} for name in grader.functions}
    for _, function, calls in recorder.iter_calls_by_kit():
        found[function].update((_arguments_key(args), args) for args in calls)
    return found


def _iter_broken_promises(
    contract: FunctionContract, calls: Mapping[bytes, Arguments], others: Mapping[bytes, Arguments]
) -> Iterator[str]:
    """Yield what is wrong with the contract of one function, by the calls of two seeds."""
    for args in calls.values():
        sizes: dict[str, int] = {}
        pairs = zip(contract.takes.items(), args, strict=False)
        odd = [name for (name, form), value in pairs if not form.matches(value, sizes)]
        if odd or len(args) > len(contract.takes) or len(args) < len(contract.takes) - len(contract.defaults):
            words = ", ".join(odd) or f"{len(args)} arguments"
            yield f"{contract.function} : les vérifications ne donnent pas ce que le contrat annonce ({words})"
            break
    fixed = [args for key, args in calls.items() if key in others]
    for edge in contract.boundaries:
        if edge.holds is not None and not any(edge.holds(*args) for args in fixed):
            yield f"{contract.function} : aucun cas fixe n’est « {edge.words} »"


def _arguments_key(args: Sequence[Value]) -> bytes:
    """Return bytes that are equal for equal arguments alone."""
    return repr([_to_picklable(arg) for arg in args]).encode()


def _to_picklable(value: Value) -> Value:
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, list | tuple):
        return [_to_picklable(item) for item in value]
    return {key: _to_picklable(item) for key, item in value.items()} if isinstance(value, dict) else value
