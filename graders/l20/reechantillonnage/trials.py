"""The checks of reechantillonner_systematique, each a list of scenarios from the plainest to the most general."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from graders.core.code.bench import Bench
from graders.core.contract.values import Arguments, Floats
from graders.l20.reechantillonnage.harvest import FUNCTION, REACH, STEP, Harvest, Objection, Scenario, harvest
from graders.l20.reechantillonnage.judge import bias, inexact, out_of_bounds, weightless_copied

#: Particles of which the weights are given by hand.
FEW = 8
RIGHT = "juste"
FROZEN = "peigne figé"

Judge = Callable[[Harvest], Objection | None]


def particles(rng: np.random.Generator, n: int, d: int) -> Floats:
    """n distinct rows (n, d): whole numbers when they are few, else multiples of STEP, exact in float32 too."""
    step = 1.0 if n <= 5 else STEP
    reach = 9 if n <= 5 else int(REACH / STEP) - 1
    side = 2 * reach + 1
    rows = np.unravel_index(rng.choice(side**d, n, replace=False), (side,) * d)
    return np.stack(rows, axis=1).astype(np.float64) * step - reach * step


def scenario(rng: np.random.Generator, weights: Iterable[float], *, d: int = 1, calls: int = 1) -> Scenario:
    """Particles for these weights: the same for every grading where the weights are."""
    w = np.array(list(weights), dtype=np.float64)
    source = np.random.default_rng(len(w)) if len(w) <= FEW else rng
    return Scenario(particles(source, len(w), d), w, calls)


def uneven_weights(rng: np.random.Generator, n: int) -> Floats:
    """Normalised weights (n,), far from equal, whose N w stay away from whole numbers."""
    while True:
        weights = rng.gamma(1.5, size=n)
        weights /= weights.sum()
        shares = n * weights
        if np.all(np.abs(shares - np.round(shares)) > 1e-5):
            return weights


def shape_scenarios(rng: np.random.Generator) -> Iterator[Scenario]:
    """One to four columns, with particles of zero weight."""
    yield scenario(rng, (0.14, 0.0, 0.56, 0.0, 0.3), d=1, calls=3)
    yield scenario(rng, (0.5, 0.0, 0.5), d=2, calls=3)
    yield scenario(rng, (0.0, 0.75, 0.0, 0.25), d=3, calls=3)
    yield scenario(rng, (0.25, 0.0, 0.125, 0.0, 0.5, 0.125), d=4, calls=3)


def whole_scenarios(rng: np.random.Generator) -> Iterator[Scenario]:
    """Weights for which every N w is whole: the copies are known exactly, whatever is drawn."""
    yield scenario(rng, (0.5, 0.5), calls=24)
    yield scenario(rng, (1.0, 0.0, 0.0, 0.0), calls=12)
    yield scenario(rng, (0.0, 0.0, 0.0, 1.0), calls=12)
    yield scenario(rng, (0.5, 0.25, 0.25, 0.0), calls=12)
    yield scenario(rng, np.full(7, 1 / 7), d=3, calls=4)
    yield scenario(rng, np.full(100, 0.01), d=2)
    yield scenario(rng, (1.0,), d=2)


def straddling_scenarios(rng: np.random.Generator) -> Iterator[Scenario]:
    """Particles that lie across two teeth, where N separate draws give too many copies or too few; then any weights.

    The third ones are whole multiples of 1/N that do not begin on one: teeth that are not spaced by 1/N miss one of
    them, or find one too many, in about half of the calls. The second ones come first in the cloud and are copied
    again: whoever writes over what is still to be read shows.
    """
    yield scenario(rng, (0.15, 0.2, 0.3, 0.35), calls=8)
    yield scenario(rng, (0.35, 0.3, 0.2, 0.15), calls=4)
    yield scenario(rng, (0.125, 0.5, 0.25, 0.125), calls=16)
    yield scenario(rng, (0.055, *(0.09, 0.11) * 4, 0.145), calls=30)
    for n in (3, 5, 6, 8):
        yield scenario(rng, uneven_weights(rng, n), d=2, calls=2)
    yield scenario(rng, uneven_weights(rng, 60), d=3)
    yield scenario(rng, uneven_weights(rng, 500), d=3)


def bias_scenarios(rng: np.random.Generator) -> Iterator[Scenario]:
    """Weights that make a bias glaring.

    In the first one N w = (0.12, 1.88, 1.8, 0.2): a draw that never comes near 0, or near 1, shows at either end. In
    the second one most particles have a small chance of a copy beside one that is nearly sure of it.
    """
    yield scenario(rng, (0.03, 0.47, 0.45, 0.05), calls=900)
    yield scenario(rng, (0.02, 0.02, 0.02, 0.49875, 0.02, 0.02, 0.02, 0.38125), d=2, calls=150)


def right_shape(bench: Bench) -> None:
    """(N, d), every row one of the particles, none of zero weight."""
    _judge_together(bench, shape_scenarios(bench.rng), weightless_copied)


def exact_copies(bench: Bench) -> None:
    """Equal weights copy each particle once, one weight of 1 copies it N times."""
    worst: Objection | None = None
    for case in whole_scenarios(bench.rng):
        objection = _judged(bench, case, inexact)
        bench.observe(FUNCTION, objection.label if objection else RIGHT, ok=objection is None)
        worst = worst or objection
        if objection and objection.fatal:
            break
    _raise(worst)


def bounded_copies(bench: Bench) -> None:
    """floor(N w) or ceil(N w) copies of each particle, in every call."""
    _judge_together(bench, straddling_scenarios(bench.rng), out_of_bounds)


def unbiased(bench: Bench) -> None:
    """N w copies on average: false alarms below 2.4e-9, see `judge`."""
    worst: Objection | None = None
    for case in bias_scenarios(bench.rng):
        harvested = harvest(bench, case)
        objection = harvested.objection or bias(harvested)
        bench.observe(FUNCTION, objection.label if objection else RIGHT, ok=objection is None)
        if objection and objection.label == FROZEN and worst is None:
            bench.observe(FUNCTION, _where_frozen(bench), ok=False)
        worst = worst or objection
        if harvested.objection:
            break
    _raise(worst)


def _where_frozen(bench: Bench) -> str:
    """Where does a comb that never moves stand? Particle 2 has a copy only for an offset in [0.495, 0.505[."""
    probe = harvest(bench, scenario(bench.rng, (0.0025, 0.37125, 0.0025, 0.62375)))
    if probe.objection:
        return probe.objection.label
    return "au milieu" if probe.copies[0, 2] else "ailleurs"


def _judge_together(bench: Bench, cases: Iterable[Scenario], judge: Judge) -> None:
    """One observation for all the scenarios: what one of them shows by chance, their whole shows for sure."""
    objections: list[Objection] = []
    misread: Objection | None = None
    for case in cases:
        harvested = harvest(bench, case)
        objection = harvested.objection or judge(harvested)
        misread = misread or harvested.objection
        objections += [objection] if objection else []
        if objection and objection.fatal:
            break
    label = misread.label if misread else "".join(sorted({sign for f in objections for sign in f.label}))
    bench.observe(FUNCTION, label or RIGHT, ok=not objections)
    _raise(objections[0] if objections else None)


def _judged(bench: Bench, case: Scenario, judge: Judge) -> Objection | None:
    harvested = harvest(bench, case)
    return harvested.objection or judge(harvested)


def _raise(objection: Objection | None) -> None:
    if objection is not None:
        raise objection.rejection


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    """Weights whose sum differs from 1 by rounding alone, so that normalising them in place shows.

    They are not in order, and the last one has two teeth in it at each call: whether sorting in place shows, an index
    leaves the cloud or a particle is written over another is not left to chance.
    """
    while True:
        weights = uneven_weights(rng, 6)
        weights = np.roll(weights, -1 - int(np.argmax(weights)))
        unsorted = weights[-1] > 2 / 6 and bool(np.any(np.diff(weights) < 0))
        if unsorted and float(np.sum(weights)) != 1.0 and sum(weights.tolist()) != 1.0:
            return {"n_eff": (weights,), FUNCTION: (particles(rng, 6, 3), weights)}
