"""What the figures show: the estimate laid over the truth, and the motions of both from one start."""

from __future__ import annotations

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.metriques.cases import alignment
from reference.se2 import relative


def absolute_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """Both trajectories as given, and the estimate after the best alignment."""
    estimate, truth = args
    best = alignment(estimate, truth)
    aligned = estimate[:, :2] @ best.R_q_p.T + best.t_q_p
    return {
        "kind": "alignment", "truth": truth[:, :2], "estimate": estimate[:, :2], "aligned": aligned,
        "expected": expected, "got": got,
    }  # fmt: skip


def relative_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """The motion of each pair, in the frame of its first pose."""
    estimate, truth, delta = args
    motions = {
        name: relative(poses[:-delta], poses[delta:])[:, :2]
        for name, poses in (("truth", truth), ("estimate", estimate))
    }
    return {"kind": "motions", "delta": delta, **motions, "expected": expected, "got": got}
