"""What both functions are asked by hand: a few weights, again and again for the comb, which draws at random.

A program that draws one number a call from the kit's generator draws the very numbers of the mutants; of another one
the rules judge what no draw explains.
"""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np

from graders.core.code.probes import (
    ProbeAnswer,
    ProbeFault,
    ProbeResults,
    Probes,
    measurement_rule,
    read_array_or_reason,
    to_finite_array,
    undo_rule,
)
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20 import world

WEIGHTS = (
    (0.1, 0.2, 0.3, 0.4),
    (0.75, 0.25),
    (0.5, 0.5, 0.0, 0.0),
    (0.25, 0.25, 0.25, 0.25),
    (0.0, 0.0, 1.0),
    (0.05, 0.6, 0.05, 0.1, 0.2),
    (1.0,),
)
CLOUD = np.array([[1.0, 2.0], [3.0, -1.0], [-4.0, 5.0], [6.0, 7.0], [-2.0, -8.0]])
UNEVEN, EQUAL, ONE, FEW = (0.1, 0.2, 0.3, 0.4), (0.25,) * 4, (0.0, 0.0, 1.0, 0.0), (0.04, 0.03, 0.9, 0.03)
TIMES = ((ONE, 3), (UNEVEN, 12), (EQUAL, 6), (FEW, 6), ((0.26, 0.0, 0.24, 0.3, 0.2), 6))
COMBED: tuple[Arguments, ...] = tuple(
    (CLOUD[: len(weights)].copy(), np.array(weights)) for weights, times in TIMES for _ in range(times)
)
STRANGE = "inconnue"
AT = {"one": range(3), "uneven": range(3, 15), "equal": range(15, 21), "few": range(21, 27)}


def read_copies(args: Arguments, value: Value) -> Value:
    """How many copies there are of each particle; the rows themselves when some are no copies; in words what else."""
    particles, weights = args
    try:
        if isinstance(value, tuple | list) and len(value) == 2 and read_array(value[1]).shape == weights.shape:
            return "couple"
        rows = read_array(value)
    except UnreadableError as error:
        return str(error)
    if rows.shape != particles.shape:
        return f"forme {rows.shape}"
    same = np.all(np.abs(rows[:, None] - particles[None]) < 1e-9, axis=2)
    return same.sum(axis=0).astype(float) if np.all(same.any(axis=1)) else [STRANGE, rows]


def _counts(shown: ProbeResults, where: str) -> list[Floats] | None:
    found = [to_finite_array(shown.got[k]) for k in AT[where]]
    counts = [one for one in found if one is not None]
    return counts if len(counts) == len(found) else None


def _words(shown: ProbeResults) -> list[ProbeAnswer]:
    return [one for one in shown.got if isinstance(one, str)]


@measurement_rule
def grows(shown: ProbeResults) -> str | None:
    """More rows at each call with the same weights."""
    shapes = [re.match(r"forme \((\d+),", one) for one in _words(shown)]
    rows = [int(shape[1]) for shape in shapes if shape]
    return "memoire" if len(rows) > 8 and all(b > a for a, b in pairwise(rows)) else None


@measurement_rule
def remembers(shown: ProbeResults) -> str | None:
    """Right at first; then always what was right at first."""
    groups = [_counts(shown, where) for where in ("one", "uneven", "equal", "few")]
    counts = [c for group in groups for c in (group or [])]
    complete = all(group is not None for group in groups)
    return "memoire" if complete and all(np.array_equal(c, (0.0, 0.0, 4.0, 0.0)) for c in counts) else None


@measurement_rule
def changed_particles(shown: ProbeResults) -> str | None:
    """Rows of the right shape that are no copies, at most calls."""
    strange = sum(isinstance(one, list) and one[0] == STRANGE for one in shown.got)
    raised = any(isinstance(one, ProbeFault) for one in shown.got)
    return "particules_modifiees" if strange > len(shown.got) / 3 and not raised else None


@measurement_rule
def left_alone(shown: ProbeResults) -> str | None:
    """One copy of each particle, whatever the weights, or wherever they are not too uneven."""
    uneven, few, one = (_counts(shown, where) for where in ("uneven", "few", "one"))
    if uneven is None or few is None or one is None or any(np.any(c != 1.0) for c in uneven):
        return None
    return "nuage_inchange" if all(np.all(c == 1.0) for c in (*few, *one)) else "seulement_si_necessaire"


@measurement_rule
def without_replacement(shown: ProbeResults) -> str | None:
    """One copy of each particle where all have a weight, and a draw that fails for want of others where few have."""
    groups = [_counts(shown, where) for where in ("uneven", "equal", "few")]
    once = all(group is not None and all(np.all(c == 1.0) for c in group) for group in groups)
    failed = [
        isinstance(one, ProbeFault) and "sans remise" in one.description for one in (shown.got[k] for k in AT["one"])
    ]
    return "sans_remise" if once and all(failed) else None


@measurement_rule
def not_rigid(shown: ProbeResults) -> str | None:
    """With equal weights, the copies change from one call to another, and are not all of one particle."""
    equal, one = _counts(shown, "equal"), _counts(shown, "one")
    if equal is None or one is None or any(c[2] != 4.0 for c in one):
        return None
    uneven = [c for c in equal if np.any(c != 1.0)]
    different = {tuple(c) for c in equal}
    are_apart = any(np.count_nonzero(c) > 1 for c in uneven)
    return "plusieurs_tirages" if len(uneven) >= 2 and len(different) >= 3 and are_apart else None


@measurement_rule
def frozen(shown: ProbeResults) -> str | None:
    """The same copies at each of the twelve calls, though right in number."""
    uneven, equal = _counts(shown, "uneven"), _counts(shown, "equal")
    if uneven is None or equal is None or any(np.any(c != 1.0) for c in equal):
        return None
    bounded = all(np.all(np.abs(c - 4.0 * np.array(UNEVEN)) < 1.0) for c in uneven)
    return "peigne_fige" if bounded and all(np.array_equal(c, uneven[0]) for c in uneven) else None


@undo_rule
def out_of_the_cloud(shown: ProbeResults) -> str | None:
    """An index beyond the last particle."""
    faults = sum(isinstance(one, ProbeFault) and one.name == "IndexError" for one in shown.got)
    return "indice_hors_du_nuage" if faults >= 2 else None


PROBES = (
    Probes(
        function="n_eff",
        calls=tuple((np.array(weights),) for weights in WEIGHTS),
        kit=world.STILL,
        read=read_array_or_reason,
    ),
    Probes(
        function="reechantillonner_systematique",
        calls=COMBED,
        kit=world.STILL,
        read=read_copies,
        random=True,
        rules=(grows, remembers, changed_particles, left_alone, without_replacement),
        last_rules=(frozen, not_rigid, out_of_the_cloud),
    ),
)
