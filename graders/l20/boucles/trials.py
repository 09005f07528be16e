"""What is asked of each of the two functions alone, and how a failure is told."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare.comparison import Mismatch, SameIndices
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats, UnreadableError, Value, read_array, read_indices
from graders.l20.boucles import calibration
from graders.l20.boucles.calibration import HUGE
from graders.l20.boucles.places import BEAMS, Pool, module_pool
from graders.l20.boucles.readings import apart, habits, is_mask, signature, tolerance
from graders.l20.boucles.stories import rotation_figure
from graders.l20.boucles.walks import lidar_call, turned
from reference.loop_closure import loop_candidates

SHIFTS = (1, 7, 18, 35)
WINDOWS = ((11, 10), (13, 12), (13, 9), (13, 3), (12, 0), (24, 11), (24, 23), (80, 79))
"""(m, i): how many scans there are, and the one from which to look back."""

WINDOW_SEED = 10
# Two scans that can be written by hand: distinct distances, one longest and one shortest ray.
RAMP = 1.0 + np.arange(BEAMS) / 4.0
BOWL = 1.0 + np.arange(BEAMS) ** 2 / 150.0
# Half a turn later all comes again but for one ray, neither long nor short, beside no extreme step: whatever ray or
# step a signature starts from, longest, shortest, widest or narrowest, there are two of them.
HALF = (2.0, 2.5, 4.5, 11.0, 3.0, 3.4, 5.0, 0.5, 6.0, 6.1, 7.7, 9.0, 8.0, 6.5, 5.2, 4.0, 2.8, 1.5)
TIES = np.array([*HALF, *HALF[:13], 6.7, *HALF[14:]])
TIED_SHIFTS = (9, 18, 31)
# The same four distances, of which the shortest comes most often in one, the longest in the other.
NARROW = np.array([*map(float, "258235258283232353232525282328232528")])
WIDE = np.array([*map(float, "852835852823838353838585828382838582")])


def example(bench: Bench) -> None:
    """The scan of the statement, turned by one ray and by a quarter of a turn, then a scan of another place."""
    here, elsewhere = signature(bench, RAMP), signature(bench, BOWL)
    shifted = {k: signature(bench, np.roll(RAMP, k)) for k in (1, 9)}
    moved = [k for k, rotated in shifted.items() if apart(here, rotated) > tolerance(here, elsewhere)]
    same = apart(here, elsewhere) <= 1e-9 * max(1e-6, float(np.max(np.abs(here))))
    bench.observe("signature", "change" if moved else "constante" if same else "convient", ok=not moved and not same)
    if moved:
        raise Rejection(
            f"Les mêmes distances, décalées de {moved[0]} rayon{'s' if moved[0] > 1 else ''}, "
            "donnent une autre signature.",
            inputs={"scan": RAMP, "scan décalé": f"np.roll(scan, {moved[0]})"},
            expected=here,
            got=shifted[moved[0]],
            figure=rotation_figure(RAMP, np.roll(RAMP, moved[0]), here, shifted[moved[0]]),
        )
    if same:
        raise Rejection(
            "Deux scans sans rien de commun ont la même signature : elle ne distingue aucun lieu.",
            inputs={"scan 1": RAMP, "scan 2": BOWL},
            expected="deux signatures différentes",
            got=here,
        )
    _must_keep_its_length(bench, elsewhere)


def _must_keep_its_length(bench: Bench, elsewhere: Floats) -> None:
    """As the statement says, signatures have one length: also that of a scan where distances come again."""
    repeated = signature(bench, NARROW)
    kept = repeated.shape == elsewhere.shape
    bench.observe("signature", "convient" if kept else "de longueur variable", ok=kept)
    if not kept:
        raise Rejection(
            f"La signature d’un scan où des distances se répètent a pour longueur {repeated.size}, celle d’un scan où "
            f"elles sont toutes différentes {elsewhere.size} : la longueur ne doit pas dépendre du scan.",
            inputs={"scan": NARROW},
            expected=f"une signature de longueur {elsewhere.size}",
            got=repeated,
        )


def rotation(bench: Bench) -> None:
    """Three places of the map: any heading gives the same signature, another place gives another one.

    Last, by hand, two rays are the longest, two the shortest: which of them comes first depends on the heading.
    """
    pool = _pool(bench)
    chosen = bench.rng.choice(len(pool.poses), 4, replace=False)
    rejections = [_turn(bench, pool, int(p), int(q)) for p, q in pairwise(chosen)]
    for rejection in rejections:
        if rejection is not None:
            raise rejection
    must_ignore_ties(bench)


def must_ignore_ties(bench: Bench) -> None:
    """Whichever of two rays at a tie comes first, the signature is the same: by two scans that never change."""
    here, elsewhere = signature(bench, TIES), signature(bench, BOWL)
    for k in TIED_SHIFTS:
        rotated = signature(bench, np.roll(TIES, k))
        if apart(here, rotated) > tolerance(here, elsewhere):
            bench.observe("signature", habits(bench, TIES, BOWL), ok=False)
            raise _tied(k, here, rotated)


def _tied(k: int, here: Floats, rotated: Floats) -> Rejection:
    return Rejection(
        f"Deux rayons sont à égalité, les plus longs du scan. Décalé de {k} rayons, il donne une autre signature : "
        "le premier des deux n'est plus le même.",
        inputs={"scan": TIES, "scan décalé": f"np.roll(scan, {k})"},
        expected=here,
        got=rotated,
        figure=rotation_figure(TIES, np.roll(TIES, k), here, rotated),
    )


def _turn(bench: Bench, pool: Pool, place: int, other: int) -> Rejection | None:
    scan, elsewhere = pool.scans[place], pool.scans[other]
    here, there = signature(bench, scan), signature(bench, elsewhere)
    for k in SHIFTS:
        rotated = signature(bench, np.roll(scan, -k))
        if apart(here, rotated) > tolerance(here, there):
            bench.observe("signature", habits(bench, scan, elsewhere), ok=False)
            return changed(pool.poses[place], scan, k, here, rotated)
    distinct = apart(here, there) > 1e-9 * max(1e-6, float(np.max(np.abs(here))))
    bench.observe("signature", "invariante" if distinct else "constante", ok=distinct)
    return None if distinct else _constant(pool.poses[place], pool.poses[other], here)


def changed(pose: Floats, scan: Floats, k: int, here: Floats, rotated: Floats) -> Rejection:
    return Rejection(
        f"Le robot tourne sur place de {10 * k}° et sa signature change : elle dépend encore du cap.",
        inputs={"scan 1": lidar_call(pose), "scan 2": lidar_call(turned(pose, k))},
        expected=here,
        got=rotated,
        figure=rotation_figure(scan, np.roll(scan, -k), here, rotated),
    )


def _constant(pose: Floats, other: Floats, here: Floats) -> Rejection:
    return Rejection(
        "Deux lieux différents ont exactement la même signature.",
        inputs={"scan 1": lidar_call(pose), "scan 2": lidar_call(other)},
        expected="deux signatures différentes",
        got=here,
    )


def window(bench: Bench) -> None:
    """With a threshold beyond any distance, exactly the scans j <= i - 10 are candidates.

    The scans are the same in every grading.
    """
    scans = window_scans()
    rejections = [_look_back(bench, scans[:m], i) for m, i in WINDOWS]
    for rejection in rejections:
        if rejection is not None:
            raise rejection


@cache
def window_scans() -> Floats:
    """Scans (24, 36) without two equal distances.

    Who drops those has signatures of several lengths, which is no mistake of the window.
    """
    scans = np.round(np.random.default_rng(WINDOW_SEED).uniform(0.5, 11.5, (80, BEAMS)), 6)
    scans.flags.writeable = False
    return scans


def _look_back(bench: Bench, scans: Floats, i: int) -> Rejection | None:
    expected = [int(j) for j in loop_candidates(scans, i, HUGE).indices]
    try:
        got = bench.call(calibration.FUNCTION, scans, i, HUGE)
    except StudentFault as fault:
        bench.observe(calibration.FUNCTION, None, ok=False, fault=fault)
        if fault.fatal or fault.outcome is Outcome.MISSING_FUNCTION:
            raise
        return Rejection(fault.message, inputs=_window_inputs(scans, i), expected=expected, cause=fault.outcome)
    mismatch = _not_indices(got) or SameIndices()(expected, got)
    bench.observe(calibration.FUNCTION, _indices_in_words(got, expected), ok=mismatch is None)
    if mismatch is None:
        return None
    return Rejection(
        f"Avec un seuil immense, tous les scans j ≤ i − 10 sont candidats, et eux seuls. {mismatch.message}",
        inputs=_window_inputs(scans, i),
        expected=expected,
        got=got,
        cause=mismatch.cause,
    )


def _not_indices(got: Value) -> Mismatch | None:
    """Booleans read as 0 and 1 would be told as indices, which they are not."""
    try:
        read_indices(got)
    except UnreadableError:
        return None
    if not is_mask(got):
        return None
    return Mismatch("La fonction renvoie des booléens (un masque) et non des indices.", cause=Outcome.INVALID_OUTPUT)


def _window_inputs(scans: Floats, i: int) -> dict[str, Value]:
    return {"scans": f"{len(scans)} scans de lieux différents", "i": i, "seuil": HUGE}


def _indices_in_words(got: Value, expected: list[int]) -> Value:
    """The indices, or in words what does not depend on the descriptor that the student chose."""
    try:
        indices = read_indices(got)
    except UnreadableError:
        return _shape_in_words(got)
    if indices != expected and sorted(indices) == expected:
        return "désordre"
    # True and 1 are one value to a comparison of numbers: a mask must stay a mask.
    return ["masque", *indices] if is_mask(got) else indices


def _shape_in_words(got: Value) -> str:
    try:
        array = read_array(got)
    except UnreadableError as error:
        return str(error)
    return "non entiers" if array.ndim == 1 else f"dimension {array.ndim}, {array.shape[-1] if array.ndim else 0}"


def _pool(bench: Bench) -> Pool:
    return module_pool(kit_seed(bench))


def kit_seed(bench: Bench) -> int:
    """The seed of the grading's kit: one pool of places serves all its checks."""
    return int(bench.kit.parameters["seed"])
