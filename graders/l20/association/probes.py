"""What the four functions are asked by hand: crowded maps, and robots that are off by a metre."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import Probes, array_or_reason
from graders.core.contract.values import Arguments, UnreadableError, Value, read_indices
from graders.l20 import world
from graders.l20.association.cases import (
    JOINTS,
    SCANS,
    drawn_scan,
    joint_by_hand,
    joint_scan,
    scans_by_hand,
    steady_scan,
)

STEADY = np.random.default_rng(23)
TABLES: tuple[Arguments, ...] = tuple(drawn_scan(STEADY, 3, 4) for _ in range(2))
#: One argument is another at a time: a memory with an incomplete key answers by the call before.
CROSSED: tuple[Arguments, ...] = tuple(tuple(TABLES[k == changed][k] for k in range(3)) for changed in range(3))
#: Of another level than those before: asked first or last, a memory of the threshold shows.
OTHER_LEVEL = (2, 3, 0.5, 2)
ALONE: tuple[Arguments, ...] = (
    *scans_by_hand(STEADY),
    *(steady_scan(*shape) for shape in (*SCANS, OTHER_LEVEL)),
)
#: Far in metres and near for what is known, then the other way round.
FAR_AND_NEAR: tuple[Arguments, ...] = tuple(
    (np.array([[x, 0.5]]), np.array([[0.0, 0.5], [0.0, 40.0]]), np.array([variance * np.eye(2)] * 2))
    for x, variance in ((4.0, 16.0), (2.0, 0.04))
)
TOGETHER: tuple[Arguments, ...] = (*joint_by_hand(STEADY), *(joint_scan(*shape) for shape in (*JOINTS, (2, 2, 0.5, 0))))


def read_numbers(args: Arguments, value: Value) -> Value:
    try:
        return np.array(read_indices(value), dtype=np.float64)
    except UnreadableError as error:
        return str(error)


PROBES = (
    Probes(function="distances2", calls=(*TABLES, *CROSSED), kit=world.STILL, read=array_or_reason),
    Probes(function="associer", calls=ALONE, kit=world.STILL, read=read_numbers),
    Probes(function="nouveaux", calls=(*FAR_AND_NEAR, *ALONE), kit=world.STILL, read=read_numbers),
    Probes(function="associer_ensemble", calls=TOGETHER, kit=world.STILL, read=read_numbers),
)
