"""Errors of a trajectory, ours beside evo's: the same numbers, and how long they take.

    PYTHONPATH=. python tests/benchmarks/bench_metrics.py TRUTH ESTIMATE [rounds]

Both are files in the KITTI format, plain or packed by gzip (KITTI_00_gt.txt and KITTI_00_ORB.txt of evo's own tests).
evo comes with the extra `benchmarks`. Alignments and errors are timed, not the reading of files.
"""

from __future__ import annotations

import copy
import gzip
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from evo.core.metrics import APE, RPE, PoseRelation, Unit
from evo.core.trajectory import PosePath3D

from reference.formats.trajectory_files import read_kitti
from reference.metrics import absolute_trajectory_error, relative_pose_error
from tests.benchmarks.measure import Contender, figure, interleave, median, table


def read(path: str) -> np.ndarray:
    data = Path(path).read_bytes()
    return read_kitti((gzip.decompress(data) if path.endswith(".gz") else data).decode())


def evo_path(matrices: np.ndarray) -> PosePath3D:
    return PosePath3D(poses_se3=list(matrices))


def evo_ate(truth: PosePath3D, estimate: PosePath3D, scale: bool) -> float:
    moved = copy.deepcopy(estimate)
    moved.align(truth, correct_scale=scale)
    return evo_rmse(APE(PoseRelation.translation_part), truth, moved)


def evo_rpe(truth: PosePath3D, estimate: PosePath3D, relation: PoseRelation) -> float:
    return evo_rmse(RPE(relation, 10, Unit.frames, all_pairs=True), truth, estimate)


def evo_rmse(metric: APE | RPE, truth: PosePath3D, estimate: PosePath3D) -> float:
    metric.process_data((truth, estimate))
    return float(metric.get_all_statistics()["rmse"])


def kept(found: dict[str, float], name: str, compute: Callable[[], float]) -> float:
    found[name] = compute()
    return 0.0


def main() -> None:
    truth, estimate = read(sys.argv[1]), read(sys.argv[2])
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 9
    theirs = evo_path(truth), evo_path(estimate)
    pairs: dict[str, tuple[Callable[[], float], Callable[[], float]]] = {
        "ATE, rigid": (lambda: absolute_trajectory_error(truth, estimate).rmse, lambda: evo_ate(*theirs, False)),
        "ATE, with scale": (
            lambda: absolute_trajectory_error(truth, estimate, "similarity").rmse,
            lambda: evo_ate(*theirs, True),
        ),
        "RPE, 10 poses, translation": (
            lambda: relative_pose_error(truth, estimate, 10, overlapping=True).translation.rmse,
            lambda: evo_rpe(*theirs, PoseRelation.translation_part),
        ),
        "RPE, 10 poses, rotation": (
            lambda: relative_pose_error(truth, estimate, 10, overlapping=True).rotation.rmse,
            lambda: evo_rpe(*theirs, PoseRelation.rotation_angle_rad),
        ),
    }
    rows = []
    for name, (ours, evos) in pairs.items():
        found: dict[str, float] = {}
        contenders = [Contender(who, partial(kept, found, who, f)) for who, f in (("ours", ours), ("evo", evos))]
        interleave(contenders, rounds)
        own, other = (median(one.total) for one in contenders)
        difference = f"{abs(found['ours'] - found['evo']):.0e}"
        rows.append((name, f"{found['ours']:.13f}", difference, figure(own), figure(other), figure(other / own)))
    print(table((f"{len(truth)} poses", "rmse", "difference", "ours, ms", "evo, ms", "evo / ours"), rows))


if __name__ == "__main__":
    main()
