"""What a node is shown by hand once a check has failed: three short lives, whose phases tell mistakes apart."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import Probes
from graders.core.contract.values import Arguments, UnreadableError, Value
from graders.l20.noeud_ros.cases import INF, NAN, beams, one_sided
from graders.l20.noeud_ros.judge import read_log
from graders.l20.noeud_ros.scenes import COMMAND, NODE, QUICK, SCAN, STILL, Scene, phase, scenario

TURNED = {"angle_min": 0.0}
SHORT = {"range_max": 0.8, "distance": 0.9}
BEGINNING = Scene(
    [
        phase(beams(36, {18: 0.2}), ""),
        phase(beams(36), ""),
        phase(beams(36, {18: 0.29}), ""),
    ],
    pace=QUICK,
)
PLACES = Scene(
    [
        phase(beams(36, {18: 0.4}), ""),
        phase(beams(36, {11: 0.2}), ""),
        phase(beams(36, dict.fromkeys(range(36), 0.1) | {15: 0.5}), ""),
        phase(beams(36, {2: 0.2}), ""),
        phase(beams(36, {33: 0.2}), ""),
        phase(beams(36, {5: 0.2}), ""),
        phase(beams(36, dict.fromkeys(range(36), 0.2)), ""),
        phase(beams(120, {60: 0.2}), ""),
        phase(beams(120, {53: 0.2}), ""),
        phase(beams(120, {66: 0.2}), ""),
        phase(beams(120, {10: 0.2}), ""),
        phase(beams(120, {117: 0.2}), ""),
        phase(beams(120, {45: 0.2}), ""),
        phase(beams(120, {75: 0.2}), ""),
        phase(beams(120, {34: 0.2}), ""),
        phase(beams(120, {90: 0.2}), ""),
        phase(beams(120, {62: 0.2}), "", **TURNED),
        phase(beams(120, {2: 0.2}), "", **TURNED),
        phase(beams(120, {117: 0.2}), "", **TURNED),
        phase(beams(61, dict.fromkeys(range(20, 40), 0.25)), ""),
        phase(beams(61, dict.fromkeys(range(61), 20.0)), ""),
        phase(beams(360, {180: 0.2}), ""),
        phase(beams(360, {173: 0.2}), ""),
        phase(beams(360, {355: 0.2}), ""),
    ],
    pace=QUICK,
)
VALUES = Scene(
    [
        phase(beams(36, {18: 0.5}), "", distance=0.6),
        phase(beams(36, {18: 0.5}), "", distance=0.3),
        phase(beams(36, {18: 0.5}), "", distance=0.8),
        phase(beams(36, {18: 0.25}), "", distance=0.15),
        phase(beams(36, {18: 0.25}), "", distance=0.3),
        phase(beams(36, {8: NAN, 18: 0.2}), ""),
        phase(beams(36, {12: NAN, 20: NAN}), ""),
        phase(beams(36, {18: 0.2, 20: NAN}), ""),
        phase(beams(36, far=INF), ""),
        phase(beams(36, {18: 0.2}, far=INF), ""),
        phase(beams(36, {18: 0.85}, far=INF), "", **SHORT),
        phase(beams(36, {18: 0.7}, far=INF), "", **SHORT),
        phase(beams(36, {18: 12.0}), "", distance=0.5),
        phase(beams(36, {18: 0.1}), "", distance=0.5, range_min=0.02),
        phase(beams(36, {18: 2e-4}), "", distance=0.5, range_min=1e-4),  # less than 0.5 in millimetres too
        *one_sided(),
    ],
    launched=0.6,
    pace=QUICK,
)


def read(args: Arguments, value: Value) -> Value:
    """What it did in each phase; where it cannot stop any robot, what it listens to and announces instead."""
    try:
        log = read_log(value)
    except UnreadableError as error:
        return str(error)
    asked = args[0]
    assert isinstance(asked, dict)
    length = asked["duree"]
    assert isinstance(length, float)
    done = np.array([log.did(number, QUICK) for number in range(round(length / QUICK.length))], dtype=float)
    place = "" if log.hears_scans and log.commands else f"{_topics(log.heard)} → {_topics(log.announced)}"
    return [done, place, bool(log.refused), any("undeclared" in reason for reason in log.refused)]


def _topics(pairs: tuple[tuple[str, str], ...]) -> str:
    """Which name a topic has is not looked at, but for the two that count."""
    known = (SCAN, COMMAND)
    return ", ".join(sorted(f"{topic if topic in known else 'autre'} {kind}" for topic, kind in pairs))


CALLS: tuple[Arguments, ...] = tuple((scenario(scene),) for scene in (BEGINNING, PLACES, VALUES))
PROBES = (Probes(function=NODE, calls=CALLS, kit=STILL, read=read),)
