"""Calling a resampling function again and again with the same weights, and counting the copies that come out."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection, fault_rejection
from graders.core.compare import words as render
from graders.core.compare.comparison import TOLERANCE, unreadable
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats, UnreadableError, Value, read_array

FUNCTION = "reechantillonner_systematique"
Counts = NDArray[np.int64]

STEP, REACH = 0.125, 64.0
#: A function that raised that often in one scenario has shown enough.
ENOUGH_FAULTS = 24


@dataclass(frozen=True)
class Scenario:
    """Particles (N, d) with distinct rows, their weights (N,), and how many times the function is called with them."""

    particles: Floats
    weights: Floats
    calls: int = 1

    @property
    def size(self) -> int:
        return len(self.weights)

    @property
    def shares(self) -> Floats:
        """N w: how many copies of each particle are expected on average."""
        return self.size * self.weights

    @property
    def low(self) -> Counts:
        """The fewest copies that a comb can give: floor(N w), an integer up to rounding counting as that integer."""
        return np.floor(self.shares + TOLERANCE).astype(np.int64)

    @property
    def high(self) -> Counts:
        """The most copies that a comb can give: ceil(N w)."""
        return np.ceil(self.shares - TOLERANCE).astype(np.int64)

    @property
    def inputs(self) -> dict[str, Value]:
        return {"particules": self.particles, "poids": self.weights}


@dataclass(frozen=True)
class Objection:
    """What was found against the function: `label` is the same for the same mistake, whatever was drawn."""

    label: str
    rejection: Rejection
    fault: StudentFault | None = None

    @property
    def fatal(self) -> bool:
        """Is calling again of no use?"""
        return self.fault is not None and (self.fault.fatal or self.fault.outcome is Outcome.MISSING_FUNCTION)


@dataclass
class Harvest:
    """The copies of each particle in each call (calls, N), or the objection that put an end to the calls."""

    scenario: Scenario
    copies: Counts
    objection: Objection | None = None

    @property
    def constant(self) -> bool:
        return len(self.copies) > 1 and not np.any(self.copies != self.copies[0])


def harvest(bench: Bench, scenario: Scenario) -> Harvest:
    """Call the function as often as the scenario says; stop at the first value that does not hold particles."""
    values: list[Floats] = []
    faults: list[StudentFault] = []
    calls = itertools.repeat((scenario.particles, scenario.weights), scenario.calls)
    for _, answer in bench.call_many(FUNCTION, calls, faults=ENOUGH_FAULTS):
        if isinstance(answer, StudentFault):
            faults.append(answer)
            continue
        array = _read(scenario, answer.value)
        if isinstance(array, Objection):
            return Harvest(scenario, _no_copies(scenario), array)
        values.append(array)
    if faults:
        return Harvest(scenario, _no_copies(scenario), _faulty(scenario, faults, always=not values))
    return _count(scenario, np.array(values))


def _no_copies(scenario: Scenario) -> Counts:
    return np.zeros((0, scenario.size), dtype=np.int64)


def _faulty(scenario: Scenario, faults: list[StudentFault], *, always: bool) -> Objection:
    """An exception; « toujours » or « parfois » is told only where the calls are enough to know."""
    fault = faults[-1] if faults[-1].fatal else faults[0]
    often = ("toujours" if always else "parfois") if scenario.size == 2 and scenario.calls >= 24 else ""
    label = f"{fault.exception or fault.outcome.value} {often}".strip()
    return Objection(label, fault_rejection(fault, inputs=scenario.inputs), fault)


def _read(scenario: Scenario, value: Value) -> Floats | Objection:
    """The value as an array (N, d), or what is wrong with it."""
    try:
        array = read_array(value)
    except UnreadableError as error:
        if _with_weights(scenario, value):
            message = "La fonction renvoie un couple (particules, poids) : on attend les particules seules."
            return _misread(scenario, "couple", message, value, cause=Outcome.INVALID_OUTPUT)
        mismatch = unreadable(error)
        return _misread(scenario, "illisible", mismatch.message, value, cause=mismatch.cause)
    return array if array.shape == scenario.particles.shape else _misshapen(scenario, array)


def _with_weights(scenario: Scenario, value: Value) -> bool:
    """Is this the particles together with their new weights?"""
    if not isinstance(value, tuple | list) or len(value) != 2:
        return False
    try:
        shapes = tuple(read_array(item).shape for item in value)
    except UnreadableError:
        return False
    return shapes == (scenario.particles.shape, scenario.weights.shape)


def _misshapen(scenario: Scenario, array: Floats) -> Objection:
    wanted, obtained = render.shape_text(scenario.particles.shape), render.shape_text(array.shape)
    message = f"La forme du résultat est {obtained} au lieu de {wanted}."
    n, d = scenario.particles.shape
    if array.shape == (n,) and _are_indices(array, n):
        message += " Ce sont les numéros des particules choisies : il manque les particules elles-mêmes."
        return _misread(scenario, "indices", message, array, slip="indices_au_lieu_de_copies")
    if array.ndim == 2 and array.shape[1] == d:
        message += f" Il faut autant de particules après qu'avant, ici {n}."
        return _misread(scenario, f"lignes {len(array)}", message, array, slip="forme")
    return _misread(scenario, f"forme {array.ndim}", message, array, slip="forme")


def _are_indices(array: Floats, n: int) -> bool:
    with np.errstate(invalid="ignore"):
        return bool(np.all((array == np.round(array)) & (array >= 0) & (array <= n)))


def _misread(
    scenario: Scenario,
    label: str,
    message: str,
    got: Value,
    *,
    slip: str | None = None,
    cause: Outcome = Outcome.WRONG_ANSWER,
) -> Objection:
    expected = f"{scenario.size} lignes, toutes prises parmi les particules données"
    rejection = Rejection(message, inputs=scenario.inputs, expected=expected, got=got, slip=slip, cause=cause)
    return Objection(label, rejection)


def _count(scenario: Scenario, rows: Floats) -> Harvest:
    """Recognise each returned row (calls, N, d) among the particles and count."""
    calls, n, d = rows.shape
    flat, recognised = _match(scenario.particles, rows.reshape(calls * n, d))
    if not np.all(recognised):
        call, row = divmod(int(np.argmin(recognised)), n)
        return Harvest(scenario, _no_copies(scenario), _stranger(scenario, rows[call], row))
    places = np.repeat(n * np.arange(calls), n) + flat
    return Harvest(scenario, np.bincount(places, minlength=n * calls).reshape(calls, n))


def _match(particles: Floats, rows: Floats) -> tuple[Counts, NDArray[np.bool_]]:
    """The particle that each row is nearest to, and whether it is that one, within the contract's tolerance.

    Particles are multiples of STEP below REACH: their coordinates, read as digits, make one number, exact in float64,
    at least STEP away from that of any other particle.
    """
    digits = (2.0 * REACH / STEP) ** np.arange(particles.shape[1])
    with np.errstate(all="ignore"):
        keys, sought = particles @ digits, STEP * np.round(rows / STEP) @ digits
        order = np.argsort(keys)
        places = np.searchsorted(keys[order] - STEP / 2, sought, side="right") - 1
        nearest = order[np.maximum(places, 0)]
        gaps = np.abs(rows - particles[nearest])
        return nearest, np.all(gaps <= TOLERANCE * np.maximum(1.0, np.abs(particles[nearest])), axis=1)


def _stranger(scenario: Scenario, got: Floats, row: int) -> Objection:
    row_text = render.text(got[row])
    if np.any(np.isnan(got)):
        return _misread(scenario, "nan", f"La ligne {row} du résultat vaut {row_text}.", got, slip="nan")
    message = f"La ligne {row} du résultat vaut {row_text} : ce n'est la copie d'aucune des particules données."
    weighted = np.allclose(got, scenario.particles * scenario.weights[:, None])
    return _misread(scenario, "pondérées" if weighted else "inconnue", message, got)
