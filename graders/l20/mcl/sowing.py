"""The trial of `initialiser`: poses anywhere on the free cells."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.contract.values import Floats
from graders.l20 import journeys, world
from graders.l20.mcl.answers import SEED, seeded
from graders.l20.mcl.scenes import SMALL
from graders.l20.mcl.telling import number, observed, thin

#: A map with fewer free cells is sown to the last one: 2000 draws miss one of fifty with a probability below 1e-15.
FEW_CELLS = 51
#: Of a cell, and of a turn in radians: what 2000 uniform draws never leave empty (1e-45, 1e-25).
EDGE, GAP = 0.05, 0.2
#: How far from a half the share of 2000 poses is in which two coordinates, drawn apart, are on the same side (1e-40).
TOGETHER = 0.15


@observed(SEED)
def sown(bench: Bench) -> None:
    """Free cells, all of them, anywhere in them, with any heading: on the module's map and on a small one."""
    _sown_well(bench, journeys.module_map().free)
    seeded(bench, 1)
    with bench.run_with_kit(world.kit(bench.rng, SMALL)) as small:
        _sown_well(small, SMALL)


def _sown_well(bench: Bench, free: NDArray[np.bool_]) -> None:
    """2000 poses. An honest draw fails with a probability below 1e-9: see the tests."""
    n = 2000
    cloud = seeded(bench, n)
    x, y, heading = cloud.T
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    inside = (column >= 0) & (column < free.shape[1]) & (row >= 0) & (row < free.shape[0])
    standing = inside & free[np.where(inside, row, 0), np.where(inside, column, 0)]
    if not standing.all():
        k = int(np.argmin(standing))
        raise _badly_sown(
            f"La particule {k}, en (x, y) = ({number(x[k])} ; {number(y[k])}), n'est pas sur une case libre. "
            f"Il y en a {np.count_nonzero(~standing)} sur {n} dans ce cas.",
            free, cloud, "des particules sur les cases libres seulement",
        )  # fmt: skip
    reached = len(set(zip(row.tolist(), column.tolist(), strict=True)))
    if reached < (1.0 if np.count_nonzero(free) < FEW_CELLS else 0.8) * np.count_nonzero(free):
        raise _badly_sown(
            f"Sur {np.count_nonzero(free)} cases libres, {n} particules n'en atteignent que {reached}.",
            free, cloud, "des particules sur toutes les cases libres",
        )  # fmt: skip
    for name, place in (("x", x - column), ("y", y - row)):
        if place.min() > EDGE or place.max() < 1.0 - EDGE or place.std() < 0.15:
            raise _badly_sown(
                f"Dans leurs cases, les particules vont selon {name} de {number(place.min())} à {number(place.max())} "
                "seulement. Le robot peut être n'importe où dans sa case, de 0 à 1.",
                free, cloud, "une place tirée au hasard dans la case",
            )  # fmt: skip
    sides = {"x": x - column > 0.5, "y": y - row > 0.5, "le cap": np.sin(heading) > 0.0}
    for (name, side), (other, other_side) in itertools.combinations(sides.items(), 2):
        share = float(np.mean(side == other_side))
        if abs(share - 0.5) > TOGETHER:
            raise _badly_sown(
                f"{name.capitalize() if len(name) > 1 else name} et {other} ne sont pas tirés séparément : ils sont du "
                f"même côté de leur milieu pour {number(100 * share)} % des particules, au lieu de 50 % environ.",
                free, cloud, "une place tirée au hasard dans la case",
            )  # fmt: skip
    turned = np.sort(np.mod(heading, math.tau))
    gaps = np.diff(turned, append=turned[0] + math.tau)
    if gaps.max() > GAP:
        raise _badly_sown(
            f"Les caps ne couvrent pas tout le tour : aucun n'est entre {number(turned[np.argmax(gaps)])} et "
            f"{number(turned[np.argmax(gaps)] + gaps.max())} rad, à un tour près.",
            free, cloud, "des caps uniformes sur un tour complet",
        )  # fmt: skip
    lean = abs(np.exp(1j * heading).mean())
    if lean > 0.2:
        raise _badly_sown(
            f"Les caps ne couvrent pas tout le tour : leur direction moyenne a la longueur {number(lean)}, "
            "alors que des "
            "caps uniformes la rendent presque nulle.",
            free, cloud, "des caps uniformes sur un tour complet",
        )  # fmt: skip


def _badly_sown(message: str, free: NDArray[np.bool_], cloud: Floats, expected: str) -> Rejection:
    return Rejection(
        message,
        inputs={"n": len(cloud), "libres": free},
        expected=expected,
        got=cloud[:8],
        figure={"kind": "cloud", "free": free, "after": thin(cloud), "title": "Vos particules au départ"},
    )
