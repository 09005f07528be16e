"""How answers are compared and told: one number for a whole scan, one distance for each cell of a map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graders.core.code.checks import Cases, Failure, Rejection
from graders.core.code.drawable import to_drawable_array
from graders.core.compare import words as render
from graders.core.compare.comparison import CloseTo, Mismatch, ScalarCloseTo
from graders.core.compare.told_apart import got_instead_of_expected_text, value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_scalar
from reference.sensors.beam import plain_log_likelihood
from reference.world.distance_map import distances_to_cells

FEW_BEAMS = 4
#: A logarithm beyond which a density is not written.
BIGGEST = 50.0


@dataclass(frozen=True)
class SameLogarithm:
    """The same number; an infinite one is told to come from a product, or a density, that has become zero."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        mismatch = ScalarCloseTo()(expected, got)
        if mismatch is None:
            return None
        try:
            infinite = math.isinf(read_scalar(got))
        except UnreadableError:
            return mismatch
        if not infinite:
            return mismatch
        return Mismatch("Un logarithme infini est celui de 0, mais aucun rayon n’est ici de densité nulle.")


def log_likelihood(z: Floats, expected: Floats, sigma: float, z_max: float, alpha: Floats, lam: float) -> float:
    """The right answer, from the arguments in their order."""
    return plain_log_likelihood(z, expected, sigma, z_max, alpha, lam)


def distance_field(libres: Floats) -> Floats:
    """The right answer."""
    return distances_to_cells(~np.asarray(libres, dtype=bool))


@dataclass(frozen=True, kw_only=True)
class Readings(Cases):
    """Cases of `log_vraisemblance`: of a few beams, the density of each is told."""

    def _rejection(self, failure: Failure) -> Rejection:
        rejection = super()._rejection(failure)
        if failure.mismatch is not None:
            rejection.message = _asked(failure)
            if not _is_finite(failure.got):
                rejection.message += f" {failure.mismatch.message}"
            rejection.args = (rejection.message,)
        return rejection


def _asked(failure: Failure) -> str:
    z, expected, sigma, z_max, alpha, lam = failure.args
    settings = (f"σ = {render.number(sigma)}, z_max = {render.number(z_max)}, α = {render.text(tuple(alpha.tolist()))}"
                f" et λ = {render.number(lam)}")  # fmt: skip
    right, obtained = value_text_pair(failure.expected, failure.got)
    if len(z) > 1:
        scan = f"Pour un scan de {len(z)} rayons, {_given(z, expected)}{settings}"
        return f"{scan}, on attend {right}, et l’on obtient {obtained}."
    density = render.number(math.exp(failure.expected), 5)
    return (
        f"Pour {_given(z, expected)}{settings}, la densité vaut {density}, de logarithme {right} ; "
        f"on obtient {obtained}{_density(failure.got)}."
    )


def _given(z: Floats, expected: Floats) -> str:
    if len(z) > FEW_BEAMS:
        return ""
    return f"z = {render.text(z.tolist())}, ẑ = {render.text(expected.tolist())}, "


def _is_finite(got: Value) -> bool:
    """Is it a number such as the right one, so that showing both says all?"""
    try:
        return math.isfinite(read_scalar(got))
    except UnreadableError:
        return False


def _density(got: Value) -> str:
    """« , le logarithme de 0,63 », where that can be said."""
    if not _is_finite(got) or abs(read_scalar(got)) > BIGGEST:
        return ""
    return f", le logarithme de {render.number(math.exp(read_scalar(got)), 5)}"


def reading_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """What is drawn: of one beam the density and what was found of it, of several what each adds."""
    z, truth, sigma, z_max, alpha, lam = args
    each = [log_likelihood(z[k : k + 1], truth[k : k + 1], sigma, z_max, alpha, lam) for k in range(len(z))]
    return {"kind": "beam" if len(z) == 1 else "beams", "z": z, "truth": truth, "sigma": sigma, "z_max": z_max,
            "alpha": alpha, "lam": lam, "each": each, "expected": expected,
            "got": None if got is None else float(got)}  # fmt: skip


@dataclass(frozen=True)
class SameField:
    """The same distance in every cell; says which cell is wrong, and by which wall it is decided."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        mismatch = CloseTo()(expected, got)
        array = to_drawable_array(got, np.shape(expected))
        if mismatch is None or array is None:
            return mismatch
        y, x = np.unravel_index(int(np.argmax(np.abs(array - expected))), array.shape)
        values = got_instead_of_expected_text(float(expected[y, x]), float(array[y, x]))
        return Mismatch(f"l’écart le plus grand est dans la case ({y}, {x}) : {values}.", mismatch.slip)


@dataclass(frozen=True, kw_only=True)
class Fields(Cases):
    """Cases of `champ_distance`."""

    def _rejection(self, failure: Failure) -> Rejection:
        rejection = super()._rejection(failure)
        if failure.mismatch is not None:
            height, width = failure.args[0].shape
            walls = np.argwhere(~failure.args[0])
            shown = ", ".join(f"({y}, {x})" for y, x in walls[:4]) + (" et ailleurs" if len(walls) > 4 else "")
            one = "un seul mur, en" if len(walls) == 1 else "des murs en"
            rejection.message = (
                f"Sur une carte de forme ({height}, {width}), avec {one} (y, x) = {shown} : {failure.mismatch.message}"
            )
            rejection.args = (rejection.message,)
        return rejection


def field_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    return {"kind": "field", "free": args[0], "expected": expected, "got": got}
