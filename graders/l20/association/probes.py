"""What the four functions are asked by hand: crowded maps, and robots that are off by a metre."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import Probes
from graders.core.contract.values import Arguments, UnreadableError, Value, read_array, read_indices
from graders.l20 import world
from graders.l20.association.cases import drawn_scan, joint_by_hand, joint_scan, scans_by_hand

STEADY = np.random.default_rng(23)
TABLES: tuple[Arguments, ...] = tuple(drawn_scan(STEADY, 3, 4) for _ in range(2))
BY_HAND = tuple(scans_by_hand(STEADY))
#: As `cases.FOUND`: small, for hundreds of mutants answer them.
PROBED: tuple[tuple[int, int, float, int], ...] = (
    (3, 3, 0.99, 12),
    (3, 3, 0.9, 12),
    (3, 3, 0.5, 25),
    (2, 3, 0.99, 9),
    (3, 4, 0.95, 6),
)
LEVELS = (0.9, 0.5, 0.999, 0.7)
SCANS: tuple[Arguments, ...] = (
    *BY_HAND,
    *(drawn_scan(STEADY, 4, 4) for _ in range(6)),
    *((*drawn_scan(STEADY, 4, 4, level=level), level) for level in LEVELS),
)
JOINTS: tuple[Arguments, ...] = (
    *joint_by_hand(STEADY),
    *(joint_scan(*shape) for shape in PROBED),
)


def read_table(args: Arguments, value: Value) -> Value:
    try:
        return read_array(value)
    except UnreadableError as error:
        return str(error)


def read_numbers(args: Arguments, value: Value) -> Value:
    try:
        return np.array(read_indices(value), dtype=np.float64)
    except UnreadableError as error:
        return str(error)


PROBES = (
    Probes(function="distances2", calls=TABLES, kit=world.STILL, read=read_table),
    Probes(function="associer", calls=SCANS, kit=world.STILL, read=read_numbers),
    Probes(function="nouveaux", calls=SCANS, kit=world.STILL, read=read_numbers),
    Probes(function="associer_ensemble", calls=JOINTS, kit=world.STILL, read=read_numbers),
)
