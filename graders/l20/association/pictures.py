"""The data of the figure of l20/association: landmarks with their gates, measurements, and who goes where."""

from __future__ import annotations

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.association.cases import LEVEL, alone, threshold

SCAN = "scan"


def scan_figure(args: Arguments, expected: Value, got: Value) -> FigureData:
    z, landmarks, S, *level = args
    return _figure(z, landmarks, threshold(level[0] if level else LEVEL) * S, expected, got)


def joint_figure(args: Arguments, expected: Value, got: Value) -> FigureData:
    z, landmarks, C, R, *level = args
    return _figure(z, landmarks, threshold(level[0] if level else LEVEL) * alone(C, R), expected, got)


def _figure(z: Floats, landmarks: Floats, gates: Floats, expected: Value, got: Value) -> FigureData:
    drawable = got is not None and len(got) == len(z)
    return {
        "kind": SCAN,
        "z": z.tolist(),
        "landmarks": landmarks.tolist(),
        "gates": gates.tolist(),
        "expected": list(expected),
        "got": [int(k) if -1 <= k < len(landmarks) else -1 for k in got] if drawable else None,
    }
