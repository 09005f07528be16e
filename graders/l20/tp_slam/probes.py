"""What each stage is asked by hand, once a check has failed: the small cases, and a corridor walked twice."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import Probes
from graders.core.contract.values import Arguments, UnreadableError, Value, read_array
from graders.l20 import world
from graders.l20.tp_slam import places, small

COARSE = 1e-3 / 1e-7
WHEELS = np.array([(0.2, 0.2), (0.1, 0.25), (0.3, 0.1), (-0.2, 0.2), (0.15, 0.05)])


def _coarse(value: Value) -> Value:
    """Poses to a thousandth: a numeric solver gives nearly the same ones."""
    try:
        array = read_array(value)
    except UnreadableError as error:
        return str(error)
    return array / COARSE if np.all(np.abs(array) < 1e3) else "perdu"


def read_match(args: Arguments, value: Value) -> Value:
    if not isinstance(value, list | tuple) or len(value) != 2:
        return "pas un couple"
    return [_coarse(value[0]), _coarse(value[1])]


def read_loops(args: Arguments, value: Value) -> Value:
    """Which pairs are joined, and how."""
    if not isinstance(value, list | tuple):
        return "pas une liste"
    try:
        return [[int(one[0]), int(one[1]), _coarse(one[2])] for one in value]
    except (TypeError, ValueError, IndexError, OverflowError):
        return "pas des triplets"


PROBES = (
    Probes(
        function="trajectoire",
        calls=((WHEELS, 0.3), (WHEELS[:1], 0.5), (2.0 * WHEELS, 0.8)),
        kit=world.STILL,
        read=lambda args, value: _turns(value),
    ),
    Probes(function="poses_cles", calls=tuple((poses,) for poses, _ in small.KEYS), kit=world.STILL, unique=False),
    Probes(
        function="recaler",
        calls=tuple(args for args, _, _ in small.MATCHES[1:]),
        kit=world.STILL,
        read=read_match,
        unique=False,
    ),
    Probes(
        function="fermetures",
        calls=((places.WALKS[0].scans, places.WALKS[0].chain),),
        unique=False,
        kit=world.STILL,
        read=read_loops,
    ),
    Probes(
        function="optimiser",
        calls=small.GRAPHS,
        kit=world.STILL,
        read=lambda args, value: _coarse(_turned(value)),
        unique=False,
    ),
    Probes(function="carte", calls=small.MAPS, kit=world.STILL, read=lambda args, value: _signs(value), unique=False),
)


def _turned(value: Value) -> Value:
    """Poses with their angles as cosine and sine."""
    try:
        poses = read_array(value)
    except UnreadableError:
        return value
    if poses.ndim != 2 or poses.shape[1] != 3:
        return value
    return np.column_stack([poses[:, :2], np.cos(poses[:, 2]), np.sin(poses[:, 2])])


def _turns(value: Value) -> Value:
    turned = _turned(value)
    return turned if isinstance(turned, np.ndarray) else _coarse(turned)


def _signs(value: Value) -> Value:
    """What each cell is said to be; the robot's own is left out."""
    try:
        array = np.sign(read_array(value))
    except UnreadableError as error:
        return str(error)
    if array.shape == small.SHAPE:
        array[4, 2] = array[4, 22] = 0.0
    return array
