"""The graphs that are asked of every program: from two poses on a line to a loop of twenty."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cache, lru_cache

import numpy as np

from graders.l20.slam_graphe.graphs import (
    EIGHTH,
    QUARTER,
    Graph,
    Weights,
    along,
    draw_settling,
    draw_slow,
    edge,
    facing_one_way,
    going_round,
    noisy,
    rows,
    various,
)
from reference.se2 import relative

# Graphs that are the same in every grading come before those that are drawn, so that what is caught does not depend on
# the seed. These were chosen because the known wrong programs that some draws let through all fail on them.
TELLING = {"chains": 4, "loops": 5, "weighted": 2, "turning": 4, "large": 31}


def cached(draw: Callable[[np.random.Generator], Iterable[Graph]]) -> Callable[[np.random.Generator], Sequence[Graph]]:
    """Keep the graphs of one seed with their optima: a diagnosis asks for the same ones again and again."""

    @lru_cache(maxsize=64)
    def from_seed(seed: int) -> tuple[Graph, ...]:
        return tuple(draw(np.random.default_rng(seed)))

    return lambda rng: from_seed(int(rng.integers(2**62)))


@cache
def always(make: Callable[[], Iterable[Graph]]) -> tuple[Graph, ...]:
    """Graphs that never change, made once: their optima are then found once."""
    return tuple(make())


def telling(graphs: str) -> np.random.Generator:
    """The generator of those of the graphs that never change."""
    return np.random.default_rng(TELLING[graphs])


@cached
def chains(rng: np.random.Generator) -> Iterable[Graph]:
    """No loop: every measurement can be satisfied. One is so at the start. Then single steps, not judged."""
    yield from always(chains_by_hand)
    yield perturbed_chain(rng)
    yield from steps(rng)


def chains_by_hand() -> Iterable[Graph]:
    yield Graph(rows((0, 0, 0), (1, 0, 0)), (edge(0, 1, (2, 0, 0)),))
    yield Graph(rows((0, 0, 0), (2, 0, 0), (4, 0, 0)), (edge(0, 1, (2, 0, 0)), edge(1, 2, (2, 0, 0))))
    yield Graph(rows((1, 2, 0), (1, 3, 0)), (edge(0, 1, (2, 1, QUARTER)),))
    yield Graph(rows((0, 1, 0), (1, 1, 0)), (edge(0, 1, (1, 2, 0)),), None)
    yield Graph(rows((0, 0, QUARTER), (0, 1, 1), (1, 2, 0)), (edge(0, 1, (2, 0, 0)), edge(1, 2, (1, 0, -QUARTER))))
    yield all_too_far()
    yield perturbed_chain(telling("chains"))


def all_too_far() -> Graph:
    """Every coordinate decreases, more than once: who looks at the greatest step, and not at its size, stops."""
    straight = (edge(0, 1, (2, 0, 0)), edge(1, 2, (2, 0, 0)))
    return Graph(rows((0, 0, 0), (2.5, 0.5, 0.5), (5, 2, 1)), straight)


def perturbed_chain(rng: np.random.Generator) -> Graph:
    """Five consistent poses, all but the first moved."""
    truth = facing_one_way(rng, 5)
    edges = tuple(edge(i, j, relative(truth[i], truth[j])) for i, j in along(5))

    def draw() -> Graph:
        moved = np.round(rng.uniform((-0.5, -0.5, -0.3), (0.5, 0.5, 0.3), (4, 3)), 1)
        return Graph(np.vstack([truth[:1], truth[1:] + moved]), edges)

    return draw_settling(draw)


def steps(rng: np.random.Generator) -> Iterable[Graph]:
    """Graphs asked for one iteration only: a first step tells mistakes apart that all end nowhere."""
    yield always(first_step)[0]
    for _ in range(3):
        graph = noisy(rng, facing_one_way(rng, 4), [(3, 0)], weights=various(rng))
        yield Graph(graph.poses, graph.edges, 1, judged=False)


def first_step() -> Iterable[Graph]:
    line = next(iter(loops_by_hand()))
    yield Graph(line.poses, line.edges, 1, judged=False)


def loops_by_hand() -> Iterable[Graph]:
    """Loops whose discrepancy is shared equally: 3 = 1 + 1 + 1, and so for an angle."""
    line = (edge(0, 1, (2, 0, 0)), edge(1, 2, (2, 0, 0)), edge(0, 2, (7, 0, 0)))
    yield Graph(rows((0, 0, 0), (2, 0, 0), (4, 0, 0)), line)
    turns = (edge(0, 1, (0, 0, 0.5)), edge(1, 2, (0, 0, 0.5)), edge(2, 0, (0, 0, -1.6)))
    yield Graph(rows((0, 0, 0), (0, 0, 0.5), (0, 0, 1)), turns)


def measured_twice() -> Iterable[Graph]:
    """One pair measured twice, and once more the other way: 2, 5 and 5 agree on 4."""
    again = (edge(0, 1, (2, 0, 0)), edge(0, 1, (5, 0, 0)), edge(1, 0, (-5, 0, 0)))
    yield Graph(rows((0, 0, 0), (2, 0, 0)), again)


@cached
def loops(rng: np.random.Generator) -> Iterable[Graph]:
    """Every edge has the same weight, the same in length and in angle."""
    yield from always(loops_by_hand)
    yield from always(measured_twice)
    yield noisy(rng, facing_one_way(rng, 4), [(3, 0)])
    yield from always(telling_loop)
    yield crossed_loop(rng)


def telling_loop() -> Iterable[Graph]:
    yield crossed_loop(telling("loops"))


def crossed_loop(rng: np.random.Generator) -> Graph:
    return noisy(rng, facing_one_way(rng, 6), [(0, 5), (4, 1)], weights=lambda k: (25.0, 25.0))


@cached
def weighted(rng: np.random.Generator) -> Iterable[Graph]:
    """A discrepancy of 5 shared 2 + 2 + 1, then any weights, then three edges that meet in one pose."""
    yield from always(weighted_by_hand)
    yield noisy(rng, facing_one_way(rng, 4), [(0, 3), (1, 3)], weights=various(rng))


def weighted_by_hand() -> Iterable[Graph]:
    line = (edge(0, 1, (1, 0, 0)), edge(1, 2, (1, 0, 0)), edge(0, 2, (7, 0, 0), 2.0))
    yield Graph(rows((0, 0, 0), (1, 0, 0), (2, 0, 0)), line)
    source = telling("weighted")
    yield noisy(source, facing_one_way(source, 6), [(5, 0), (4, 1), (2, 3), (1, 0)], weights=various(source))


@cached
def turning(rng: np.random.Generator) -> Iterable[Graph]:
    """Headings that pass the half turn: in the result, in the error, on both ways."""
    yield from always(turning_by_hand)
    yield from rounds(rng)


def turning_by_hand() -> Iterable[Graph]:
    yield Graph(rows((0, 0, 3 * EIGHTH), (-1, 1, math.pi)), (edge(0, 1, (1, 0, QUARTER)),))
    yield Graph(rows((0, 0, -3 * EIGHTH), (-1, -1, 3 * EIGHTH)), (edge(0, 1, (1, 0, -QUARTER)),))
    yield from rounds(telling("turning"))


def rounds(rng: np.random.Generator) -> Iterable[Graph]:
    yield noisy(rng, going_round(rng, 4), [(3, 0)])
    yield noisy(rng, going_round(rng, 6), [(5, 0), (1, 4)], weights=various(rng))


@cached
def large(rng: np.random.Generator) -> Iterable[Graph]:
    """A loop of 8 poses that takes more than a few iterations, and one of 20 left to the default number of them."""
    yield from always(telling_slow)
    yield slow(rng)
    strong: Weights = lambda k: (100.0, 400.0) if k >= 19 else (25.0, 100.0)  # noqa: E731
    closures = [(19, 0), (0, 10), (15, 5), (18, 1)]
    yield noisy(rng, going_round(rng, 20), closures, noise=(0.15, 0.06), weights=strong, n_iter=None)


def telling_slow() -> Iterable[Graph]:
    yield slow(telling("large"))


def slow(rng: np.random.Generator) -> Graph:
    rough, weights = going_round(rng, 8), various(rng)
    return noisy(rng, rough, [(7, 0), (2, 6)], noise=(0.2, 0.25), weights=weights, n_iter=15, choose=draw_slow)
