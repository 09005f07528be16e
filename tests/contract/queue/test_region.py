"""The simulation of a region (`tests/benchmarks/region.py`), held to what queueing theory says in closed form."""

from __future__ import annotations

import json
from math import factorial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.benchmarks.region import (
    GRADERS,
    PUT,
    WEB,
    Costs,
    Fleet,
    Moment,
    Route,
    arrivals,
    lived,
    measured,
    moments,
    processor_hours,
    simulate,
)

JOBS = 20_000
COSTS = Costs.read()


def poisson(rate: float, seed: int = 3) -> Any:
    return np.cumsum(np.random.default_rng(seed).exponential(1.0 / rate, JOBS))


def mean_wait(when: Any, seconds: Any, servers: int) -> float:
    routes: list[Route] = [((GRADERS, one),) for one in seconds.tolist()]
    waits = simulate(when.tolist(), routes, {GRADERS: servers})
    return float(np.mean([one[GRADERS] for one in waits]))


def erlang_c(servers: int, load: float) -> float:
    """The probability of waiting in M/M/c, where `load` is the mean number of busy servers."""
    last = load**servers / factorial(servers) / (1 - load / servers)
    return last / (sum(load**k / factorial(k) for k in range(servers)) + last)


@pytest.mark.parametrize(("servers", "used"), [(1, 0.5), (3, 0.8), (10, 0.8)])
def test_mean_wait_of_several_servers_is_erlang_s(servers: int, used: float) -> None:
    """M/M/c: Wq = C(c, a) / (c µ - λ), with µ = 1. Within 15 %: waits of neighbours go together."""
    rate = servers * used
    seconds = np.random.default_rng(4).exponential(1.0, JOBS)
    expected = erlang_c(servers, rate) / (servers - rate)
    assert mean_wait(poisson(rate), seconds, servers) == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("spread", [0.0, 1.0, 2.0])
def test_mean_wait_of_one_server_is_pollaczek_khinchine_s(spread: float) -> None:
    """M/G/1: Wq = λ E[S²] / 2 (1 - ρ), whatever the law of S; here a gamma one, or always the same."""
    rate, shape = 0.6, spread and 1 / spread**2
    seconds = np.random.default_rng(5).gamma(shape, 1 / shape, JOBS) if spread else np.ones(JOBS)
    expected = rate * (1 + spread**2) / 2 / (1 - rate)
    assert mean_wait(poisson(rate), seconds, 1) == pytest.approx(expected, rel=0.12)


def test_stations_serve_in_order_of_arrival() -> None:
    routes: list[Route] = [((WEB, 2.0), (PUT, 1.0), (WEB, 1.0)), ((WEB, 2.0),), ((PUT, 1.5),)]
    waits = simulate([0.0, 0.5, 1.0], routes, {WEB: 1, PUT: 1})
    # The second waits for the first one's page (until 2), who waits for the third one's turn (until 2.5), then for the
    # second one's page (until 4).
    assert waits == [{WEB: 0.5, PUT: 0.5}, {WEB: 1.5}, {PUT: 0.0}]


def test_arrivals_rise_as_they_are_told_to() -> None:
    when = arrivals(np.random.default_rng(1), 200_000, 100.0, 3.0)
    assert (np.diff(when) >= 0).all()
    assert when[0] >= 0
    assert when[-1] <= 100
    counts, _ = np.histogram(when, 10, (0, 100))
    density = counts / counts.sum() * 10
    assert density == pytest.approx(np.linspace(0.55, 1.45, 10), rel=0.05)  # 1 to 3, over a mean of 2, in the middles


def test_more_graders_shorten_waits_and_what_breaks_first_is_told() -> None:
    moment = Moment("", 120.0, 0, 1.0, 600, 2.0, grading="deadline")
    few, many = (lived(moment, COSTS, Fleet(4, graders, 4)) for graders in (8, 30))
    assert np.percentile(few.verdicts, 95) > 2 * np.percentile(many.verdicts, 95)
    assert few.fullest[GRADERS] == pytest.approx(many.fullest[GRADERS] * 30 / 8)
    assert max(few.fullest, key=lambda one: few.fullest[one]) == GRADERS
    assert len(few.verdicts) == pytest.approx(600 * 2 * 2, rel=0.1)
    assert (few.verdicts > 0).all()


def test_a_day_costs_in_proportion() -> None:
    assert {part: 2 * one for part, one in processor_hours(100, COSTS).items()} == processor_hours(200, COSTS)
    assert [one.working for one in moments(50_000)] == [10_000, 10_000]
    assert [one.arriving for one in moments(800, 1.0)] == [800, 0]


def test_a_run_of_the_crowd_calibrates_it(tmp_path: Path) -> None:
    run = {
        "milliseconds": {
            "module": [50],
            "verdict told": [10],
            "verdict shown": [10],
            "figure": [5],
            "submission": [35],
        },
        "normalised_processor_seconds": {"web": 1.0, "graders": 2.0, "figures": 0.5, "database": 0.1, "NATS": 0.01},
    }
    path = tmp_path / "run.json"
    path.write_text(json.dumps(run))
    read = Costs.read(crowd=path)
    assert (read.request, read.lesson, read.figure) == (0.01, 0.2, 0.1)
    assert measured(run)["database"] == pytest.approx(0.01)  # type: ignore[arg-type]
    assert read.deadline == COSTS.deadline
