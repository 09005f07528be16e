"""Both functions together: is there a threshold that finds the visits of one place, and those alone?

What never changes comes first: a mistake that it catches costs the same in every grading. How a program that the
look-alikes catch fares on the walks of one grading is up to their draw, and is not held against it: `sosies` tells it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.findings import FigureData
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.boucles import calibration, scenes
from graders.l20.boucles.calibration import Outcome, Search, calibrate
from graders.l20.boucles.lookalikes import lookalikes
from graders.l20.boucles.places import STILL, Rng, module_pool, two_places
from graders.l20.boucles.readings import apart, signature, tolerance
from graders.l20.boucles.stories import comparison, places_figure, tell
from graders.l20.boucles.trials import changed, kit_seed, must_ignore_ties
from graders.l20.boucles.walks import Walk, draw_trap

Draw = Callable[[int], Walk]

CHANCES = 3
"""Walks on which a submission may show one threshold that separates: an unlucky one is no evidence."""

UP_TO_THE_DRAW = (Outcome.MIXED, Outcome.ALWAYS)


def places(bench: Bench) -> None:
    """On the module's map, without noise."""
    _at_home(bench, with_noise=False)


def noisy_places(bench: Bench) -> None:
    """On the module's map, each scan with its own noise."""
    _at_home(bench, with_noise=True)


def _at_home(bench: Bench, *, with_noise: bool) -> None:
    _must_ignore_heading(bench)
    search = _search(bench, calibration.FUNCTION, partial(scenes.steady_walk, with_noise=with_noise))
    if search.found_one:
        drawn = partial(scenes.walk_at_home, kit_seed(bench), with_noise=with_noise)
        again = _search(bench, calibration.FUNCTION, drawn, search.threshold)
        if again.outcome not in UP_TO_THE_DRAW or _search(bench, calibration.FUNCTION, lookalikes).found_one:
            search = again
    _conclude(bench, search)


def other_places(bench: Bench) -> None:
    """The same file launched on another map, with scans of that map."""
    _must_ignore_heading(bench)
    with bench.run_with_kit(world.kit(bench.rng, scenes.map_elsewhere())) as other:
        search = _search(other, calibration.FUNCTION, scenes.walk_elsewhere)
        _conclude(other, search, " Ces scans sont ceux d'une autre carte que celle du module.")


def _conclude(bench: Bench, search: Search, remark: str = "") -> None:
    bench.observe(calibration.FUNCTION, search.outcome.value, ok=search.found_one)
    if not search.found_one:
        raise _failure(bench, search, remark)


def traps(bench: Bench) -> None:
    """Places that share a number: the look-alikes that never change, then two of this grading.

    For a signature that is one number, two places that share that one, too. One that starts from an extreme ray, of
    which noise makes another, escapes from some traps and not from others: it is turned away before.
    """
    _must_ignore_heading(bench)
    must_ignore_ties(bench)
    search = _search(bench, "signature", lookalikes)
    if search.found_one:
        draw = partial(scenes.trap, kit_seed(bench), _draw_seed(bench.rng))
        drawn = _search(bench, "signature", draw, search.threshold)
        own = _own_trap(bench) if drawn.found_one else None
        search = _search(bench, "signature", own) if own else drawn
    bench.observe("signature", search.outcome.value, ok=search.found_one)
    if not search.found_one:
        # What is told is of no use to a mistake that is re-enacted, which keeps its calls for what is observed.
        raise _failure(bench, search, "" if bench.runner.reenacting else comparison(bench, search))


def _must_ignore_heading(bench: Bench) -> None:
    """A signature that follows the heading may find a place, or escape from a trap, by luck: it is turned away before.

    By two scans that never change, so that its mark does not either.
    """
    scan, elsewhere = two_places()
    here, there = signature(bench, scan), signature(bench, elsewhere)
    rotated = signature(bench, np.roll(scan, -7))
    if apart(here, rotated) > tolerance(here, there):
        bench.observe("signature", "suit le cap", ok=False)
        raise changed(np.array(STILL[0]), scan, 7, here, rotated)


def _own_trap(bench: Bench) -> Draw | None:
    pool = module_pool(scenes.STEADY)
    if signature(bench, pool.scans[0]).size != 1:
        return None

    def number(scans: Floats) -> Floats:
        return np.array([float(signature(bench, scan)[0]) for scan in scans])

    shared = "la même signature, ou presque"
    try:
        walk = draw_trap(np.random.default_rng(scenes.STEADY), pool, number, shared, readings=12, pairs=12)
    except LookupError:
        return None
    return lambda again: walk


def _search(bench: Bench, function: str, draw: Draw, guess: float | None = None) -> Search:
    """Look for a threshold, over `CHANCES` walks at most. A fault is held against `function`, and raised."""
    try:
        search = first = calibrate(bench, draw(0), guess)
        for again in range(1, CHANCES):
            if search.outcome is not Outcome.MIXED:
                break
            search = calibrate(bench, draw(again), guess)
    except StudentFault as fault:
        bench.observe(function, None, ok=False, fault=fault)
        raise
    return search if search.found_one else first


def _failure(bench: Bench, search: Search, remark: str) -> Rejection:
    figure: FigureData | None = None
    if not bench.runner.reenacting and search.outcome is not Outcome.UNREADABLE:
        figure = places_figure(bench, search)
    return tell(search, remark, figure)


def _draw_seed(rng: Rng) -> int:
    return int(rng.integers(2**62))
