"""l20/calcul_kabsch: the rigid motion between two triangles, by hand."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from graders.core.answers.numeric import numeric
from graders.core.answers.quantity import Data, Formula, Quantity, Values

Floats = NDArray[np.float64]

ROTATIONS = [(c, s) for c, s in ((0.6, 0.8), (0.8, 0.6), (-0.6, 0.8), (-0.8, 0.6))]
NAMES = [f"{cloud}{k}{axis}" for k in (1, 2, 3) for cloud in "pq" for axis in "xy"]
LEAST_AREA = 0.5


def deal(rng: np.random.Generator) -> Data:
    """A triangle on a grid of half metres, turned by an angle whose cosine and sine are tenths: all is exact."""
    p = _triangle(rng)
    c, s = ROTATIONS[int(rng.integers(len(ROTATIONS)))]
    s *= float(rng.choice([-1.0, 1.0]))
    t = rng.integers(-30, 31, 2) / 10
    q = np.round(p @ np.array([[c, s], [-s, c]]) + t, 1)
    rows = np.hstack([p, q]).ravel().tolist()
    return {name: float(value) + 0.0 for name, value in zip(NAMES, rows, strict=True)}


def _triangle(rng: np.random.Generator) -> Floats:
    while True:
        p = rng.integers(-4, 7, (3, 2)) / 2
        (ux, uy), (vx, vy) = p[1] - p[0], p[2] - p[0]
        if abs(ux * vy - uy * vx) / 2 >= LEAST_AREA:
            return np.asarray(p, dtype=np.float64)


def clouds(data: Data) -> tuple[Floats, Floats]:
    rows = np.array([data[name] for name in NAMES]).reshape(3, 4)
    return rows[:, :2], rows[:, 2:]


def _centre(cloud: int, axis: int) -> Formula:
    return lambda d, _: float(clouds(d)[cloud][:, axis].mean())


def _sum(cloud: int, axis: int) -> Formula:
    return lambda d, _: float(clouds(d)[cloud][:, axis].sum())


def _cross(row: int, column: int) -> Formula:
    """A coefficient of H, around the centres that were found."""

    def formula(data: Data, earlier: Values) -> float:
        p, q = clouds(data)
        centred_p = p[:, row] - earlier[("pbx", "pby")[row]]
        return float(centred_p @ (q[:, column] - earlier[("qbx", "qby")[column]]))

    return formula


def _not_centred(row: int, column: int) -> Formula:
    return lambda d, _: float(clouds(d)[0][:, row] @ clouds(d)[1][:, column])


def _mean(formula: Formula) -> Formula:
    return lambda d, f: formula(d, f) / 3


def theta(_: Data, earlier: Values) -> float:
    """The angle that makes tr(R H) greatest."""
    return math.atan2(earlier["h12"] - earlier["h21"], earlier["h11"] + earlier["h22"])


def _turned(earlier: Values, angle: float, axis: int) -> float:
    """One coordinate of the centre of P, turned."""
    c, s = math.cos(angle), math.sin(angle)
    return earlier["pbx"] * c - earlier["pby"] * s if axis == 0 else earlier["pbx"] * s + earlier["pby"] * c


def _translation(axis: int, angle: Callable[[Values], float]) -> Formula:
    return lambda _, f: f[("qbx", "qby")[axis]] - _turned(f, angle(f), axis)


REL, ABS = 0.004, 0.003


def _coefficient(row: int, column: int) -> Quantity:
    right = _cross(row, column)
    slips = {"sans_centrer": _not_centred(row, column), "divise_par_n": _mean(right)}
    if row != column:
        slips["h_transposee"] = _cross(column, row)
    return Quantity(f"h{row + 1}{column + 1}", 1.5, right, rel=REL, abs=ABS, slips=slips)


def _centre_of(id: str, cloud: int, axis: int) -> Quantity:
    return Quantity(id, 1, _centre(cloud, axis), rel=REL, abs=ABS, slips={"somme_sans_division": _sum(cloud, axis)})


def _along(id: str, axis: int) -> Quantity:
    slips = {
        "centre_non_tourne": lambda _, f: f[("qbx", "qby")[axis]] - f[("pbx", "pby")[axis]],
        "rotation_transposee": _translation(axis, lambda f: -f["theta"]),
    }
    return Quantity(id, 3, _translation(axis, lambda f: f["theta"]), rel=REL, abs=0.01, slips=slips)


QUANTITIES = (
    _centre_of("pbx", 0, 0),
    _centre_of("pby", 0, 1),
    _centre_of("qbx", 1, 0),
    _centre_of("qby", 1, 1),
    _coefficient(0, 0),
    _coefficient(0, 1),
    _coefficient(1, 0),
    _coefficient(1, 1),
    Quantity(
        "theta",
        4,
        theta,
        rel=0.0,
        abs=0.005,
        angle=True,
        slips={
            "rotation_transposee": lambda d, f: -theta(d, f),
            "atan2_echange": lambda _, f: math.atan2(f["h11"] + f["h22"], f["h12"] - f["h21"]),
            "degres": lambda d, f: math.degrees(theta(d, f)),
        },
    ),
    _along("tx", 0),
    _along("ty", 1),
)

DEFINITION = numeric(__file__, deal=deal, quantities=QUANTITIES)
