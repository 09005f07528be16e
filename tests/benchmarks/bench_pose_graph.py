"""Pose graphs side by side: this project's Gauss-Newton, with qdldl and without, against g2opy, gtsam and graphslam.

    pip install '.[fast,benchmarks]'
    OPENBLAS_NUM_THREADS=1 PYTHONPATH=. python tests/benchmarks/bench_pose_graph.py FOLDER [--rounds 9] [--slow]

FOLDER holds INTEL.g2o, M3500.g2o and city10000.g2o. The time is that of the optimisation from the file's start, in the
process' own memory, all that each library sets up for it included (ordering, sparsity), reading and building left out.
Each solver does as many iterations as it needs to come within 1e-6, relatively, of the best chi2 found: counted before.
Rounds are interleaved; the ratio is ours by the peer's within each round. A peer that is not installed is left out.
"""

from __future__ import annotations

import argparse
import contextlib
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reference.pose_graph import G2oGraph, chi2, factor, gauss_newton, loads_g2o
from reference.se2 import wrap_angle
from tests.benchmarks.measure import Goal, Row, figure

SETS = ("INTEL", "M3500", "city10000")
TOLERANCE = 1e-6
MOST = 15
GOALS = {"g2opy": Goal(1.0), "gtsam": Goal(0.6)}  # ours by theirs
Run = Callable[[int], tuple[float, np.ndarray]]  # iterations -> seconds, poses (n, 3)


def ours(content: G2oGraph, _: Path, *, with_qdldl: bool) -> Run:
    installed = factor.qdldl
    if with_qdldl and installed is None:
        raise ImportError("qdldl")

    def run(iterations: int) -> tuple[float, np.ndarray]:
        factor.qdldl = installed if with_qdldl else None
        begin = time.perf_counter()
        found = gauss_newton(content.graph, content.poses, max_iterations=iterations, tolerance=0.0)
        taken = time.perf_counter() - begin
        factor.qdldl = installed
        return taken, found.poses

    return run


def g2opy(content: G2oGraph, _: Path) -> Run:
    import g2opy as g2o

    def build() -> g2o.SparseOptimizer:
        graph, optimizer = content.graph, g2o.SparseOptimizer()
        solver = g2o.BlockSolverSE2(g2o.LinearSolverEigenSE2())
        optimizer.set_algorithm(g2o.OptimizationAlgorithmGaussNewton(solver))
        for k, pose in enumerate(content.poses):
            vertex = g2o.VertexSE2()
            vertex.set_id(k)
            vertex.set_estimate(g2o.SE2(*pose))
            vertex.set_fixed(k in graph.fixed)
            optimizer.add_vertex(vertex)
        for i, j, z, omega in zip(graph.i, graph.j, graph.z_i_j, graph.information, strict=True):
            edge = g2o.EdgeSE2()
            edge.set_vertex(0, optimizer.vertex(int(i)))
            edge.set_vertex(1, optimizer.vertex(int(j)))
            edge.set_measurement(g2o.SE2(*z))
            edge.set_information(omega)
            optimizer.add_edge(edge)
        return optimizer

    def run(iterations: int) -> tuple[float, np.ndarray]:
        optimizer = build()
        begin = time.perf_counter()
        optimizer.initialize_optimization()
        optimizer.optimize(iterations)
        taken = time.perf_counter() - begin
        vertices = optimizer.vertices()
        return taken, np.array([vertices[k].estimate().to_vector() for k in range(content.graph.n_poses)])

    return run


def gtsam(content: G2oGraph, path: Path) -> Run:
    import gtsam as library

    def run(iterations: int) -> tuple[float, np.ndarray]:
        graph, values = library.readG2o(str(path))
        tight = library.noiseModel.Diagonal.Sigmas(np.full(3, 1e-6))
        graph.add(library.PriorFactorPose2(0, values.atPose2(0), tight))
        settings = library.GaussNewtonParams()
        settings.setMaxIterations(iterations)
        settings.setRelativeErrorTol(0.0)
        settings.setAbsoluteErrorTol(0.0)
        begin = time.perf_counter()
        found = library.GaussNewtonOptimizer(graph, values, settings).optimize()
        taken = time.perf_counter() - begin
        poses = (found.atPose2(k) for k in range(content.graph.n_poses))
        return taken, np.array([[p.x(), p.y(), p.theta()] for p in poses])

    return run


def graphslam(content: G2oGraph, path: Path) -> Run:
    from graphslam.graph import Graph

    def run(iterations: int) -> tuple[float, np.ndarray]:
        graph = Graph.from_g2o(str(path))
        begin = time.perf_counter()
        with contextlib.redirect_stdout(None):
            graph.optimize(tol=0.0, max_iter=iterations, fix_first_pose=True)
        taken = time.perf_counter() - begin
        return taken, np.array([vertex.pose.to_array() for vertex in graph._vertices])

    return run


SOLVERS: dict[str, Callable[[G2oGraph, Path], Run]] = {
    "ours, qdldl": lambda content, path: ours(content, path, with_qdldl=True),
    "ours, SuperLU": lambda content, path: ours(content, path, with_qdldl=False),
    "g2opy": g2opy,
    "gtsam": gtsam,
}


def reached(content: G2oGraph, poses: np.ndarray) -> float:
    """chi2 of poses, whatever frame they came back in."""
    poses = np.column_stack([poses[:, :2], wrap_angle(poses[:, 2])])
    return chi2(content.graph, poses)


def needed(run: Run, content: G2oGraph, optimum: float) -> int:
    """How many iterations bring a solver to the optimum."""
    for iterations in range(1, MOST + 1):
        if reached(content, run(iterations)[1]) <= optimum * (1.0 + TOLERANCE):
            return iterations
    raise ArithmeticError(f"not at the optimum after {MOST} iterations")


@dataclass(frozen=True)
class Compared:
    """One set: iterations that each solver needs, milliseconds of each round, and why others are left out."""

    name: str
    size: str
    iterations: dict[str, int]
    times: dict[str, list[float]]
    left_out: dict[str, str]

    def ratio(self, peer: str) -> float:
        """Ours by the peer's: the median of the ratios within each round."""
        ours = next(iter(self.times.values()))
        return statistics.median(own / other for own, other in zip(ours, self.times[peer], strict=True))


def compare(path: Path, rounds: int, solvers: dict[str, Callable[[G2oGraph, Path], Run]]) -> Compared:
    content = loads_g2o(path.read_text())
    optimum = gauss_newton(content.graph, content.poses).chi2[-1]
    entrants: dict[str, tuple[Run, int]] = {}
    left_out: dict[str, str] = {}
    for name, make in solvers.items():
        try:
            run = make(content, path)
            entrants[name] = run, needed(run, content, optimum)
        except (ImportError, RuntimeError, ArithmeticError) as error:
            left_out[name] = str(error).strip().splitlines()[0]
    times: dict[str, list[float]] = {name: [] for name in entrants}
    for _ in range(rounds):
        for name, (run, iterations) in entrants.items():
            times[name].append(1e3 * run(iterations)[0])
    size = f"{content.graph.n_poses} poses, {len(content.graph.i)} edges, chi2 {optimum:.8g}"
    return Compared(path.stem, size, {name: one for name, (_, one) in entrants.items()}, times, left_out)


def rows(folder: Path, rounds: int, sets: Sequence[str] = SETS) -> list[Row]:
    """The ratio to each peer that has a goal, set by set."""
    made = []
    for compared in (compare(folder / f"{name}.g2o", rounds, SOLVERS) for name in sets):
        middles = {name: statistics.median(times) for name, times in compared.times.items()}
        told = ", ".join(f"{name} {figure(one)} ms" for name, one in middles.items())
        for peer, goal in GOALS.items():
            subject = f"pose graph {compared.name}: ours ÷ {peer}"
            if peer in compared.times:
                made.append(Row(subject, "×", compared.ratio(peer), peers=told, goal=goal))
            else:
                made.append(Row.missing(subject, f"{peer}: {compared.left_out[peer]}", goal))
    return made


def told(compared: Compared) -> None:
    print(f"\n{compared.name}: {compared.size}")
    for name, why in compared.left_out.items():
        print(f"  {name:14} left out: {why}")
    base = next(iter(compared.times.values()))
    for name, times in compared.times.items():
        low, middle, high = min(times), statistics.median(times), max(times)
        print(
            f"  {name:14} {compared.iterations[name]:2} iterations  median {middle:8.1f} ms  [{low:.1f} … {high:.1f}]"
            f"  ours/it: median {compared.ratio(name):.2f}, least {min(base) / low:.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--slow", action="store_true", help="graphslam too, which takes seconds an iteration")
    chosen = parser.parse_args()
    solvers = {**SOLVERS, "graphslam": graphslam} if chosen.slow else SOLVERS
    for name in SETS:
        told(compare(chosen.folder / f"{name}.g2o", chosen.rounds, solvers))


if __name__ == "__main__":
    main()
