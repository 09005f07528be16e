"""What `vers_logodds` and `vers_proba` are asked: numbers, arrays of any shape, log-odds beyond what exp can hold."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial

import numpy as np

from graders.core.code.checks import Cases
from graders.core.compare.comparison import CloseTo
from graders.core.compare.shrinking import Shrinker, keep_unchanged
from graders.core.contract.values import Arguments, Floats, Value
from reference.occupancy import log_odds, probability_of_log_odds

LOG_ODDS, PROBABILITY = "vers_logodds", "vers_proba"
REFERENCES: dict[str, Callable[[Value], Floats]] = {LOG_ODDS: log_odds, PROBABILITY: probability_of_log_odds}
NAMES = {LOG_ODDS: ("p",), PROBABILITY: ("l",)}
SIMPLE = {LOG_ODDS: (0.7, 0.5, 0.3, 0.9, 0.01, 0.999, 0.25), PROBABILITY: (0.0, 0.847, -0.847, 2.0, -5.0, 5.0, -0.3)}
SPREAD = {LOG_ODDS: (0.02, 0.98), PROBABILITY: (-5.0, 5.0)}
BEYOND = (800.0, -800.0, 40.0, -40.0, 1500.0, -1500.0)


def numbers(function: str, rng: np.random.Generator) -> Iterator[Arguments]:
    """Python floats, then arrays without a dimension."""
    yield from ((value,) for value in SIMPLE[function])
    yield from ((float(value),) for value in _drawn(function, rng, (3,)))
    yield (np.array(SIMPLE[function][0]),)
    yield (np.array(SIMPLE[function][3]),)


def arrays(function: str, rng: np.random.Generator) -> Iterator[Arguments]:
    """A row, a grid that is not square, a single value in an array."""
    yield (np.array(SIMPLE[function][:3]),)
    yield (np.array(SIMPLE[function][1:]).reshape(2, 3),)
    yield (np.array([SIMPLE[function][3]]),)
    for shape in ((5,), (4, 3), (1, 6)):
        yield (_drawn(function, rng, shape),)


def beyond(rng: np.random.Generator) -> Iterator[Arguments]:
    """Log-odds of which the exponential overflows, as numbers, then together."""
    yield from ((value,) for value in BEYOND)
    yield (np.array([*BEYOND, 0.0]),)


def _drawn(function: str, rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    return np.round(rng.uniform(*SPREAD[function], shape), 3)


def fewer(value: Value) -> Iterator[Value]:
    """One entry alone, while there are several."""
    flat = np.asarray(value).ravel()
    if flat.size > 1:
        yield from (flat[k : k + 1] for k in range(min(flat.size, 8)))


def elementwise(
    id: str,
    title: str,
    points: float,
    function: str,
    cases: Callable[[np.random.Generator], Iterable[Arguments]],
    hint: str,
    shrinker: Shrinker = keep_unchanged,
) -> Cases:
    """A check of one of the two functions."""
    return Cases(
        id=id, title=title, points=points, functions=(function,), names=NAMES[function], cases=cases,
        expected=REFERENCES[function], compare=CloseTo(), shrinkers=(shrinker,), hint=hint,
    )  # fmt: skip


ODDS = (
    elementwise(
        "logodds_nombres",
        "De la probabilité au log-odds : un nombre",
        1,
        LOG_ODDS,
        partial(numbers, LOG_ODDS),
        "Que doit valoir le log-odds d’une case dont on ne sait rien, p = 0,5 ? Et est-il positif pour p = 0,7 ?",
    ),
    elementwise(
        "logodds_tableaux",
        "De la probabilité au log-odds : un tableau, case par case",
        1,
        LOG_ODDS,
        partial(arrays, LOG_ODDS),
        "Votre fonction accepte-t-elle une grille entière ? Que fait math.log d’un tableau, et np.log ?",
        fewer,
    ),
    elementwise(
        "proba_nombres",
        "Du log-odds à la probabilité : un nombre",
        1,
        PROBABILITY,
        partial(numbers, PROBABILITY),
        "Que doit valoir la probabilité pour ℓ = 0 ? Et quand ℓ grandit, vers quoi doit-elle aller ?",
    ),
    elementwise(
        "proba_tableaux",
        "Du log-odds à la probabilité : un tableau, case par case",
        1,
        PROBABILITY,
        partial(arrays, PROBABILITY),
        "Votre fonction accepte-t-elle une grille entière, et renvoie-t-elle une grille de la même forme ?",
        fewer,
    ),
    elementwise(
        "proba_extremes",
        "Du log-odds à la probabilité : ℓ immense, dans les deux sens",
        1,
        PROBABILITY,
        beyond,
        "Que vaut exp(800) pour votre ordinateur ? Et l’infini divisé par l’infini ?",
        fewer,
    ),
)
