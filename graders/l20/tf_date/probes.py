"""What the three functions are asked by hand: uneven gaps, turns across the back, links of all sorts, all refusals."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import ProbeFault, ProbeResults, Probes, measurement_rule
from graders.core.contract.values import Arguments, UnreadableError, Value, read_array
from graders.l20 import world
from graders.l20.tf_date import cases
from graders.l20.tf_date.cases import dated, fixed, pose
from graders.l20.tf_date.truth import UNKNOWN_DATE, UNKNOWN_FRAME

PAIRS: tuple[Arguments, ...] = (
    (pose(1.2, -0.7, 0.3), pose(2.9, 4.1, 1.4), 0.3),
    (pose(0.4, 1.1, -1.2), pose(-2.2, 0.6, 0.9), 0.7),
    (pose(0.4, 1.1, 2.9), pose(-2.2, 0.6, -2.4), 0.4),
    (pose(3.3, 1.7, -2.2), pose(2.1, 5.6, 1.9), 0.8),
    (pose(3.3, 1.7, -2.8), pose(2.1, 5.6, 2.9), 0.25),
    (pose(0.5, 0.2, 1.1), pose(1.7, 2.3, 2.6), 0.0),
    (pose(0.5, 0.2, 1.1), pose(1.7, 2.3, 2.6), 1.0),
)
DATES = np.array([1.0, 1.4, 3.2, 3.9, 6.5])
PLACES = np.array([[0.2, 1.1, 0.3], [1.9, 0.4, 1.2], [2.7, 2.2, 2.9], [4.4, 1.3, -2.6], [5.1, 3.6, -1.4]])
AT: tuple[Arguments, ...] = (
    (DATES, PLACES, 1.1),
    (DATES, PLACES, 2.7),
    (DATES, PLACES, 3.3),
    (DATES, PLACES, 5.6),
    (DATES, PLACES, 3.2),
    (DATES, PLACES, 1.0),
    (DATES, PLACES, 6.5),
    (DATES, PLACES, 7.3),
    (DATES, PLACES, 0.2),
    (DATES[:1], PLACES[:1], 1.0),
    (DATES[:1], PLACES[:1], 1.3),
    (DATES[:1], PLACES[:1], 0.7),
)
BACK = [
    dated("m", "o", 4.0, 1.3, -0.4, 0.6),
    dated("o", "b", 7.0, 3.1, 0.7, -2.7),
    dated("o", "b", 3.0, 0.2, 0.9, 2.4),
    fixed("b", "l", 0.4, -0.3, 1.1),
    dated("m", "o", 6.0, 1.9, -0.1, 0.9),
    dated("o", "b", 4.5, 1.7, 1.2, 3.0),
    dated("b", "c", 1.0, 0.7, 0.8, 0.9),
]
#: A date of zero is no missing date.
SINCE_ZERO = [dated("m", "o", 0.0, 1.2, 0.3, 0.4), dated("m", "o", 2.0, 2.6, -0.5, 1.3)]
LOOKUPS: tuple[Arguments, ...] = (
    (cases.TURNED, "a", "c", 7.0),
    (BACK, "b", "l", 5.0),
    (BACK, "o", "b", 4.0),
    (BACK, "m", "o", 4.6),
    (BACK, "o", "l", 3.9),
    (BACK, "m", "l", 5.2),
    (BACK, "m", "b", 6.0),
    (BACK, "m", "l", 4.5),
    (BACK, "m", "m", 50.0),
    (BACK, "b", "l", 50.0),
    (BACK, "m", "l", 6.5),
    (BACK, "m", "l", 3.5),
    (BACK, "o", "b", 7.5),
    (BACK, "m", "z", 5.0),
    (BACK, "z", "l", 5.0),
    (BACK, "b", "m", 5.0),
    (SINCE_ZERO, "m", "o", 1.5),
    (SINCE_ZERO, "m", "o", 2.5),
)


def read_pose(args: Arguments, value: Value) -> Value:
    """Three numbers; in words what is none."""
    try:
        found = read_array(value)
    except UnreadableError as error:
        return str(error)
    return found


@measurement_rule
def exchanged(shown: ProbeResults) -> str | None:
    """All that is wrong is the exception: one of the two for the other."""
    both = {UNKNOWN_FRAME, UNKNOWN_DATE}
    pairs = [(shown.got[k], shown.right[k]) for k in shown.wrong_indices()]
    if pairs and all(isinstance(a, ProbeFault) and isinstance(b, ProbeFault) for a, b in pairs):
        return "exceptions_echangees" if all({a.name, b.name} == both for a, b in pairs) else "autre_exception"
    return None


@measurement_rule
def never_refuses(shown: ProbeResults) -> str | None:
    """All is right but what must be refused, to which something is answered."""
    wrong = shown.wrong_indices()
    refused = [k for k, one in enumerate(shown.right) if isinstance(one, ProbeFault)]
    answered = all(not isinstance(shown.got[k], ProbeFault) for k in wrong)
    return "repond_toujours" if wrong and answered and set(wrong) <= set(refused) else None


PROBES = (
    Probes(function="interpoler", calls=PAIRS, kit=world.STILL, read=read_pose),
    Probes(
        function="a_la_date", calls=AT, kit=world.STILL, read=read_pose, last_rules=(exchanged, never_refuses),
        unless=frozenset({"interpoler"}),
    ),
    Probes(
        function="chercher", calls=LOOKUPS, kit=world.STILL, read=read_pose, last_rules=(exchanged, never_refuses),
        unless=frozenset({"interpoler", "a_la_date"}),
    ),
)  # fmt: skip
