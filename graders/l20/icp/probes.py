"""What `icp` is asked by hand: one iteration and many, from a start or none, unequal clouds, a mirror, no count."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graders.core.code.probes import ProbeResults, Probes, measurement_rule
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20 import world
from graders.l20.icp import cases
from graders.l20.icp.descent import DEFAULT, Registration, Step, descend, staircase
from graders.l20.icp.judge import ERROR_ABSOLUTE, ERROR_RELATIVE, misplaced, read, unread

#: Seeds for which programs that go astray do so alike however numbers are rounded, but for a few.
KINDS = (
    (cases.TWO, 0), (cases.ONE, 1), (cases.SAME, 6), (cases.FROM, 1), (cases.ONE_FROM, 5), (cases.MORE, 7),
    (cases.FEWER, 0), (cases.NOISY, 0), (cases.MIRROR, 3), (cases.THREE_FROM, 0), (cases.THREE_FROM, 1),
)  # fmt: skip


def _asked(kind: cases.Kind, seed: int) -> Registration:
    """The registration of a seed, with hardly more iterations than it takes: mutants do not stop by themselves."""
    case = kind.made(seed)
    if case.n_iter != DEFAULT:
        return case
    return case._replace(n_iter=len(descend(*case[:4], DEFAULT)) + 1)


#: The last two are one registration, first with the number of iterations, then without.
ASKED: tuple[Registration, ...] = (
    *(_asked(kind, kind.seeds[k]) for kind, k in KINDS),
    cases.example(3),
    *(cases.MANY.made(cases.LONGEST)._replace(n_iter=n_iter) for n_iter in (DEFAULT, None)),
)
OF_ERRORS: tuple[Registration, ...] = (
    *(_asked(kind, kind.seeds[1]) for kind in (cases.SHORT, cases.NOISY, cases.ONE_FROM, cases.THREE_FROM)),
    cases.example(3),
)
#: What is shown of errors that are no sum in any usual way, that rise, that are one number, that cannot be read.
OTHER, RISES, SINGLE, UNREAD = 7.0, 8.0, 9.0, 10.0


def registration(args: Arguments) -> Registration:
    """The arguments of a call, where the count may be missing."""
    return Registration(*args[:4], *(args[4:] or (None,)))


def read_place(args: Arguments, value: Value) -> Value:
    """R and t in one row; in words what is no triple."""
    mismatch = unread(value)
    if mismatch is not None:
        return mismatch.message
    answer = read(value)
    return np.concatenate([answer.R.ravel(), answer.t])


def read_errors(args: Arguments, value: Value) -> Value:
    """What the errors are, where R and t are right: 0 for sums of squares of any moment; 0 too where they are not."""
    case = registration(args)
    if unread(value) is not None or misplaced(case, value) is not None:
        return 0.0
    try:
        found = read_array(read(value).errors)
    except UnreadableError:
        return UNREAD
    if found.ndim == 0:
        return SINGLE
    if found.ndim != 1 or not 1 <= found.size <= case.iterations + 1 or not np.all(np.isfinite(found)):
        return UNREAD
    if np.any(np.diff(found) > 1e-6 * np.maximum(1.0, np.abs(found[:-1]))):
        return RISES
    steps = descend(*case[:4], case.iterations + 1)
    stairs, lengths, n = staircase(steps), _lengths(case, steps), len(case.P)
    ways = {
        0.0: stairs,
        1.0: stairs / n,
        2.0: np.sqrt(stairs),
        3.0: np.sqrt(stairs / n),
        4.0: lengths,
        5.0: lengths / n,
    }
    return next((way for way, values in ways.items() if _among(values, found)), OTHER)


def _lengths(case: Registration, steps: Sequence[Step]) -> Floats:
    """The sums of distances where `staircase` has those of squares."""
    found, R, t = [], case.R0, case.t0
    for step in steps:
        for turned, moved in ((R, t), (step.R, step.t)):
            gaps = case.P @ turned.T + moved - case.Q[step.pairs]
            found.append(float(np.sum(np.hypot(*gaps.T))))
        R, t = step.R, step.t
    return np.array(found)


def _among(values: Floats, found: Floats) -> bool:
    gaps = np.abs(values[:, None] - found) <= ERROR_ABSOLUTE + ERROR_RELATIVE * values[:, None]
    return bool(np.all(np.any(gaps, axis=0)))


@measurement_rule
def only_without_count(shown: ProbeResults) -> str | None:
    """Right each time that the number of iterations is given, the same one among them."""
    return "defaut_faux" if shown.wrong_indices() == [len(shown.calls) - 1] else None


def _arguments(asked: tuple[Registration, ...]) -> tuple[Arguments, ...]:
    return tuple(case.arguments for case in asked)


PROBES = (
    Probes(
        function="icp",
        calls=_arguments(ASKED),
        compared=len(ASKED) - 2,  # after thirty iterations, who goes astray is anywhere
        kit=world.STILL,
        read=read_place,
        rules=(only_without_count,),
    ),
    Probes(function="icp", calls=_arguments(OF_ERRORS), kit=world.STILL, read=read_errors),
)
