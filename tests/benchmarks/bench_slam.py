"""The front end on real logs, with its default settings: errors beside the published ones, and time a scan.

    OPENBLAS_NUM_THREADS=1 PYTHONPATH=. python tests/benchmarks/bench_slam.py FOLDER [NAME ...]

FOLDER holds the data sets: `laser/NAME.log`, or `.log.gz`, corrected logs of CARMEN with their ODOM lines, and where
there is one the file `laser/NAME.relations` of Freiburg's benchmark, with `laser/NAME.stamps`: for each scan of the log
its time by the clock of the relations, one a line, nan where unknown. Without names, all logs that are there. They are
not in the repository: intel.gfs comes from xiaofeng419/SLAM-2D-LIDAR-SCAN, as do the relations, and the stamps of Intel
(the keys of `intel_corrected_log`, in the order of the poses); the others of `PUBLISHED` from acschaefer/ple,
`data/carmen/NAME-corrected.log.gz`. The logs' own times are no substitute: some are a second off.

Errors by relations compare with what a person has measured; those against the log's own poses, by GMapping, say how
two mappers differ, and not which of them is right.
"""

from __future__ import annotations

import gzip
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reference.formats.carmen import LaserLog, parse_flaser
from reference.formats.relations import parse_relations
from reference.front_end import SlamResult, slam
from reference.metrics import RelativeError, absolute_trajectory_error, relation_error
from reference.se2 import relative
from tests.benchmarks.measure import Goal, Row

USABLE = 40.0
PACE_GOAL = Goal(50.0)


# Mean and deviation of the absolute errors by relations, in metres and degrees.
PUBLISHED = {
    "intel.gfs": "GMapping 0.070 ± 0.083, 2.99 ± 5.39; graph mapping 0.031 ± 0.026, 1.3 ± 4.7; "
    "Cartographer 0.0229 ± 0.0239, 0.453 ± 1.335",
    "aces": "graph mapping 0.044 ± 0.044, 0.4 ± 0.4; Cartographer 0.0375 ± 0.0426, 0.373 ± 0.469",
    "freiburg-079": "graph mapping 0.056 ± 0.042, 0.6 ± 0.6; Cartographer 0.0452 ± 0.0354, 0.538 ± 0.718",
    "infinite-corridor": "graph mapping 0.050 ± 0.056, 0.5 ± 0.5; Cartographer 0.0395 ± 0.0488, 0.352 ± 0.353",
}


@dataclass(frozen=True)
class Mapped:
    """A log and what came out, in milliseconds of processor time a scan; `by_relations`: None where there are none."""

    log: LaserLog
    found: SlamResult
    pace: float
    by_relations: RelativeError | None

    @property
    def from_wheels(self) -> float:
        return absolute_trajectory_error(self.log.T_odom_robot, self.log.wheel_poses()).rmse

    @property
    def from_mapper(self) -> float:
        return absolute_trajectory_error(self.log.T_odom_robot, self.found.T_map_robot).rmse

    @property
    def strange_closures(self) -> int:
        """How many closures that count are half a metre or more from the log's own poses."""
        keys, poses = self.found.keys, self.log.T_odom_robot
        gaps = [relative(relative(poses[keys[c.i]], poses[keys[c.j]]), c.match.T_a_b) for c in self.found.closures]
        return sum(np.hypot(gap[0], gap[1]) > 0.5 for gap in gaps)


def map_log(folder: Path, name: str) -> Mapped:
    log = parse_flaser(_read(folder / f"{name}.log"), USABLE)
    begun = time.process_time()
    found = slam(log.scans, log.wheel_poses(), resolution=0.1)
    pace = (time.process_time() - begun) * 1e3 / len(log)
    relations, stamps = (folder / f"{name}.{kind}" for kind in ("relations", "stamps"))
    if not (relations.is_file() and stamps.is_file()):
        return Mapped(log, found, pace, None)
    times = np.array(stamps.read_text().split(), dtype=np.float64)
    dated = np.flatnonzero(np.isfinite(times))
    pairs, T = parse_relations(relations.read_bytes()).select_between_times(times[dated])
    return Mapped(log, found, pace, relation_error(found.T_map_robot, dated[pairs], T) if len(pairs) else None)


def _read(path: Path) -> bytes:
    packed = path.with_name(f"{path.name}.gz")
    return gzip.decompress(packed.read_bytes()) if packed.is_file() else path.read_bytes()


def names_in(folder: Path) -> list[str]:
    return sorted({path.name.removesuffix(".gz").removesuffix(".log") for path in folder.glob("*.log*")})


def told(error: RelativeError) -> str:
    metres, degrees = error.translation, np.degrees(error.rotation.values)
    return (
        f"{len(error.pairs)} relations: {metres.mean:.4f} ± {metres.std:.4f} m, "
        f"{degrees.mean():.3f} ± {degrees.std():.3f}°"
    )


def rows(data: Path | None) -> list[Row]:
    """Time a scan of the Intel log, and the errors beside the published ones."""
    subject = "SLAM, Intel log: a scan"
    if data is None or not names_in(data / "laser"):
        return [Row.missing(subject, "no folder of data sets holds laser/intel.gfs.log", PACE_GOAL)]
    mapped = map_log(data / "laser", "intel.gfs")
    peers = f"{mapped.from_mapper:.3f} m from the log's own poses, wheels alone {mapped.from_wheels:.1f} m"
    return [Row(subject, "ms", mapped.pace, peers=peers, goal=PACE_GOAL)]


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ["BALISE_DATA"]) / "laser"
    for name in sys.argv[2:] or names_in(folder):
        mapped = map_log(folder, name)
        found = mapped.found
        lost = sum(link.match is None for link in found.links)
        print(
            f"{name}: {len(mapped.log)} scans, {len(found.keys)} key poses, {lost} links by odometry alone, "
            f"{len(found.closures)} closures, {mapped.strange_closures} of them far from the log's, "
            f"{len(found.refused)} refused; ATE {mapped.from_wheels:.2f} m by wheels, "
            f"{mapped.from_mapper:.3f} m mapped; {mapped.pace:.1f} ms a scan"
        )
        if mapped.by_relations is not None:
            print(f"  {told(mapped.by_relations)}")
        if name in PUBLISHED:
            print(f"  published: {PUBLISHED[name]}")


if __name__ == "__main__":
    main()
