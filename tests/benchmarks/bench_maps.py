"""ICP beside small_gicp, A* and log-odds mapping beside naive versions: interleaved in one process; medians, ratios.

pip install "balise[benchmarks]"
BALISE_DATA=... python tests/benchmarks/bench_maps.py [points of the large cloud]
"""

from __future__ import annotations

import gzip
import math
import os
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from scipy.spatial import cKDTree

from reference.formats.carmen import parse_flaser
from reference.occupancy import build_map
from reference.planning import SearchGrid, parse_map, parse_scenarios
from reference.registration import icp, icp_to_lines, normals_by_neighbours
from tests.benchmarks.measure import Goal, Row, figure

DATA = Path(os.environ.get("BALISE_DATA") or Path(__file__).resolve().parents[2].parent / "shared" / "data")
ICP_GOAL = Goal(2.0)  # ours by small_gicp's, at equal error


def interleaved(rounds: int, **actions: Callable[[], Any]) -> dict[str, list[float]]:
    """Milliseconds of processor of each action, round after round side by side, after one round that does not count."""
    times: dict[str, list[float]] = {name: [] for name in actions}
    for number in range(rounds + 1):
        for name, action in actions.items():
            start = time.process_time()
            action()
            if number:
                times[name].append(1000.0 * (time.process_time() - start))
    return times


@dataclass(frozen=True)
class Compared:
    """Milliseconds of processor of each contender, round by round; the peer is who the others are told beside."""

    title: str
    times: dict[str, list[float]]
    peer: str
    notes: dict[str, str] = field(default_factory=dict)

    def ratio(self, name: str) -> float:
        return statistics.median(self.times[name]) / statistics.median(self.times[self.peer])


def report(found: Compared) -> None:
    print(f"\n{found.title}")
    for name, values in found.times.items():
        spread = f"{min(values):.2f} .. {max(values):.2f}"
        middle, note = statistics.median(values), found.notes.get(name, "")
        print(f"  {name:22} {middle:10.2f} ms  ({spread})  x{found.ratio(name):.2f}  {note}")


def error(P: Any, Q: Any, R: Any, t: Any) -> float:
    return float(np.sqrt(np.mean(cKDTree(Q).query(P @ R.T + t)[0] ** 2)))


def bench_icp(title: str, P: Any, Q: Any, rounds: int) -> Compared:
    import small_gicp

    def peer(kind: str) -> Any:
        target, source = (small_gicp.PointCloud(np.column_stack([c, np.zeros(len(c))])) for c in (Q, P))
        tree = small_gicp.KdTree(target)
        return small_gicp.align(
            target, source, tree, np.eye(4), registration_type=kind, max_correspondence_distance=1e3,
            max_iterations=200, rotation_epsilon=1e-9, translation_epsilon=1e-9,
        )  # fmt: skip

    actions: dict[str, Callable[[], Any]] = {
        "small_gicp ICP": lambda: peer("ICP"),
        "icp": lambda: icp(P, Q, max_iterations=200),
        "icp accelerated": lambda: icp(P, Q, max_iterations=200, accelerated=True),
        "icp_to_lines": lambda: icp_to_lines(P, Q, normals_by_neighbours(Q), max_iterations=200),
    }
    notes = {}
    for name, action in actions.items():
        found = action()
        T = found.T_target_source if name.startswith("small") else None
        R, t = (T[:2, :2], T[:2, 3]) if T is not None else (found.R_q_p, found.t_q_p)
        notes[name] = f"rms {error(P, Q, R, t):.9f} after {found.iterations} iterations"
    return Compared(title, interleaved(rounds, **actions), "small_gicp ICP", notes)


def boxes() -> tuple[Any, Any]:
    return np.loadtxt(DATA / "icp/2D_twoBoxes.csv"), np.loadtxt(DATA / "icp/2D_oneBox.csv", delimiter=",")


def outline(n: int) -> tuple[Any, Any]:
    """Two noisy samples of one closed curve, the first turned by 0.1 rad and moved."""
    rng = np.random.default_rng(0)

    def sample() -> Any:
        a = rng.uniform(0, 2 * np.pi, n)
        curve = np.column_stack([10 * np.cos(a) + 0.5 * np.cos(5 * a), 6 * np.sin(a) + 0.5 * np.sin(3 * a)])
        return curve + rng.normal(0, 0.02, (n, 2))

    c, s = math.cos(0.1), math.sin(0.1)
    return (sample() - [0.3, 0.2]) @ np.array([[c, -s], [s, c]]), sample()


def naive_astar(free: Any, start: Any, goal: Any) -> float:
    """A* as tutorials write it: dictionaries of tuples, a heap of nodes, the straight-line heuristic."""
    costs, done, queue = {start: 0.0}, set(), [(0.0, start)]
    while queue:
        _, (y, x) = heappop(queue)
        if (y, x) in done:
            continue
        done.add((y, x))
        if (y, x) == goal:
            return costs[goal]
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                v, u = y + dy, x + dx
                if (dy, dx) == (0, 0) or not free[v, u] or not (free[y, u] and free[v, x]):
                    continue
                cost = costs[y, x] + math.hypot(dy, dx)
                if cost < costs.get((v, u), math.inf):
                    costs[v, u] = cost
                    heappush(queue, (cost + math.hypot(goal[0] - v, goal[1] - u), (v, u)))
    return math.inf


def bench_astar() -> Compared:
    free = parse_map(gzip.decompress((DATA / "astar/AR0011SR.map.gz").read_bytes()).decode())
    cases = parse_scenarios((DATA / "astar/AR0011SR.map.scen").read_text())[::160]
    grid = SearchGrid(free)
    cells = sum(grid.astar(c.start, c.goal).expanded_count for c in cases)
    times = interleaved(
        5,
        naive=lambda: [naive_astar(free, c.start, c.goal) for c in cases],
        astar=lambda: [grid.astar(c.start, c.goal) for c in cases],
        dijkstra=lambda: [grid.dijkstra(c.start, c.goal) for c in cases],
    )
    per_cell = 1000.0 * statistics.median(times["astar"]) / cells
    return Compared(f"A*, {len(cases)} scenarios", times, "naive", {"astar": f"{per_cell:.2f} us a cell settled"})


def naive_map(log: Any, scans: int, resolution: float) -> Any:
    """Log-odds as tutorials write them: Bresenham's line for every beam, a cell at a time."""
    cells: dict[tuple[int, int], float] = {}
    for scan, (x, y, theta) in zip(log.scans[:scans], log.T_world_laser[:scans].tolist(), strict=True):
        for r, a in zip(scan.ranges.tolist(), scan.angles.tolist(), strict=True):
            u, v = int(x // resolution), int(y // resolution)
            end_u = int((x + r * math.cos(theta + a)) // resolution)
            end_v = int((y + r * math.sin(theta + a)) // resolution)
            du, dv = abs(end_u - u), -abs(end_v - v)
            su, sv, err = (1 if u < end_u else -1), (1 if v < end_v else -1), du + dv
            while (u, v) != (end_u, end_v):
                cells[v, u] = max(-5.0, cells.get((v, u), 0.0) - 0.847)
                twice = 2 * err
                if twice >= dv:
                    err, u = err + dv, u + su
                if twice <= du:
                    err, v = err + du, v + sv
            if r < scan.max_range:
                cells[v, u] = min(5.0, cells.get((v, u), 0.0) + 0.847)
    return cells


def bench_mapping() -> Compared:
    text = gzip.decompress((DATA / "laser/intel.gfs.log.gz").read_bytes()).decode()
    log, count = parse_flaser(text, 40.0), 100
    times = interleaved(
        5,
        naive=lambda: naive_map(log, count, 0.1),
        build_map=lambda: build_map(log.scans[:count], log.T_world_laser[:count], 0.1),
    )
    each = statistics.median(times["build_map"]) / count
    title = f"Log-odds, {count} scans of the Intel log"
    return Compared(title, times, "naive", {"build_map": f"{each:.3f} ms a scan"})


def bench_boxes(rounds: int = 25) -> Compared:
    return bench_icp("ICP, two boxes on one: 361 points", *boxes(), rounds=rounds)


def bench_outline(size: int, rounds: int = 2) -> Compared:
    return bench_icp(f"ICP, an outline of {size} points", *outline(size), rounds=rounds)


def rows(size: int, data: Path | None) -> list[Row]:
    """Ours by the peer's, the quicker of two where there are two. What cannot be measured here says why."""
    asked: tuple[tuple[str, Callable[[], Compared], tuple[str, ...], Goal | None, bool], ...] = (
        ("ICP, 361 points: ours ÷ small_gicp", bench_boxes, ("icp", "icp accelerated"), ICP_GOAL, True),
        (f"ICP, {size} points: ours ÷ small_gicp", lambda: bench_outline(size), ("icp", "icp accelerated"), ICP_GOAL,
         False),
        ("A*: ours ÷ naive", bench_astar, ("astar",), None, True),
        ("log-odds map: ours ÷ naive", bench_mapping, ("build_map",), None, True),
    )  # fmt: skip
    return [_row(subject, measure, ours, goal, data is None and needs) for subject, measure, ours, goal, needs in asked]


def _row(
    subject: str, measure: Callable[[], Compared], ours: Sequence[str], goal: Goal | None, without_data: bool
) -> Row:
    if without_data:
        return Row.missing(subject, "neither --data nor BALISE_DATA names a folder of data sets", goal)
    try:
        found = measure()
    except (ImportError, OSError) as error:
        return Row.missing(subject, str(error), goal)
    told = ", ".join(f"{name} {figure(statistics.median(times))} ms" for name, times in found.times.items())
    return Row(subject, "×", min(found.ratio(name) for name in ours), peers=told, goal=goal)


if __name__ == "__main__":
    report(bench_boxes())
    report(bench_outline(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000))
    report(bench_astar())
    report(bench_mapping())
