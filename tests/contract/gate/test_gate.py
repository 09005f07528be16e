"""The gate: nobody holds up anybody. A class member's pages and verdicts while each flood of the table goes on.

Idle and flooded times are measured in turn, on the same machine, and again where a door seems closed: what else goes on
there weighs on both. So it is no neighbour of other tests: `pytest tests/contract/gate` runs it, after the other tests
in CI. The fast gate lets several floods go on at once; `-m slow` has each alone, on one machine and on several.
`python -m tests.contract.gate.table` prints the figures.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from server.base.settings import Settings
from tests.contract.gate.bystander import PAGE_BESIDE_OTHERS, Bystander, Samples, measure, measure_idle
from tests.contract.gate.floods import ALL, FLOODS
from tests.contract.gate.service import Service, one_machine, several_machines
from tests.support.cluster import Machine

CONNECTIONS = (
    "connections opened and left",
    "one-byte chunks",
    "many headers",
    "slow loris",
    "half a body, byte by byte",
)
READ = ("search with 4,000 characters", "deep JSON", "huge forms", "forms of percent signs")
TEACHERS = ("list bombs of a teacher", "colouring bombs")
PROGRAMS = ("endless loops of a guest", "endless cells")
#: Floods take the processors from other tests, whose work weighs on what is measured.
pytestmark = pytest.mark.skipif(
    "PYTEST_XDIST_WORKER" in os.environ, reason="it is measured alone: pytest tests/contract/gate"
)


@pytest.fixture(scope="module")
def service(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """Figures are drawn by the slow gate alone."""
    is_slow = "slow" in request.config.option.markexpr
    with one_machine(tmp_path_factory.mktemp("gate"), warm_figures=is_slow) as running:
        yield running


@pytest.fixture
def cluster(tmp_path: Path, shared_settings: Settings, machines: list[Machine]) -> Iterator[Service]:
    assert not machines, "they are processes of their own; the stream goes with the fixture"
    with several_machines(tmp_path, str(shared_settings.database_url), shared_settings.nats_url) as running:
        yield running


@pytest.fixture(scope="module")
def bystander(service: Service) -> Iterator[Bystander]:
    with closing(Bystander(service)) as somebody:
        yield somebody


@pytest.fixture(scope="module")
def idle(service: Service, bystander: Bystander) -> Samples:
    return measure_idle(service, bystander, {"page", "verdict", "cell", "steps"})


@pytest.mark.long
@pytest.mark.parametrize(
    ("names", "doors"),
    [(CONNECTIONS, {"page"}), (READ, {"page"}), (TEACHERS, {"page"}), (PROGRAMS, {"page", "verdict", "cell", "steps"})],
    ids=["connections", "requests", "texts", "programs"],
)
def test_floods_hold_up_nobody(
    service: Service, bystander: Bystander, idle: Samples, names: tuple[str, ...], doors: set[str]
) -> None:
    outcome = measure(service, bystander, names, doors, rounds=4, page=PAGE_BESIDE_OTHERS, idle=idle)
    assert any(any(outcome.done[name].values()) for name in names), outcome.done
    assert not outcome.closed, outcome.closed


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOODS)
def test_no_flood_holds_up_anybody(service: Service, bystander: Bystander, name: str) -> None:
    outcome = measure(service, bystander, [name], rounds=3)
    assert not outcome.closed, outcome.closed


@pytest.mark.slow
def test_floods_hold_up_nobody_on_several_machines(cluster: Service) -> None:
    names = ("one-byte chunks", "deep JSON", "endless loops of a guest")
    with closing(Bystander(cluster)) as bystander:
        outcome = measure(cluster, bystander, names, {"page", "verdict"}, rounds=4, page=PAGE_BESIDE_OTHERS)
    assert not outcome.closed, outcome.closed


@pytest.mark.slow
def test_no_flood_holds_up_anybody_on_several_machines(cluster: Service) -> None:
    """Those that take what machines share: the queue of graders, and the database."""
    closed = []
    with closing(Bystander(cluster)) as bystander:
        for name, flood in FLOODS.items():
            if flood.fast or flood.doors == ALL:
                closed += measure(cluster, bystander, [name], {"page", "verdict"}, rounds=3).closed
    assert not closed, closed
