"""`balise serve` answers while the walls are tried, and runs no student's code before they are known to stand."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import replace

import pytest

from server.base.app_services import get_service
from server.base.concurrency import Gate
from server.cli import serve
from server.cli.serve import open_walls_once_probed
from server.health.metrics import PrometheusMetrics
from server.sandbox import WallReport, WallStatus
from tests.support.service import Site


def wall(status: WallStatus, *, required: bool = True) -> WallReport:
    return WallReport("seccomp", status, "dit pourquoi", required=required)


GOOD, HOLE = wall(WallStatus.STANDING), wall(WallStatus.MISSING)
SPARED = wall(WallStatus.MISSING, required=False)


@pytest.mark.parametrize(
    ("found", "opens"),
    [([GOOD], True), ([GOOD, SPARED], True), ([GOOD, HOLE], False), ([], False), ([SPARED], False), (None, False)],
)
def test_the_gate_opens_where_every_required_wall_was_tried_and_stands(
    found: list[WallReport] | None, opens: bool, site: Site
) -> None:
    probing: Future[list[WallReport]] = Future()
    walls, left = Gate(), []
    open_walls_once_probed(probing, walls, get_service(site.app, PrometheusMetrics), lambda: left.append(True))
    assert not walls.is_open
    assert not left
    if found is None:
        probing.set_exception(OSError("the probe has failed"))
    else:
        probing.set_result(found)
    assert walls.is_open is opens
    assert bool(left) is not opens


def test_nothing_is_ready_before_the_walls_are_tried(site: Site) -> None:
    from server.health.readiness import ReadinessChecks

    readiness = get_service(site.app, ReadinessChecks)
    assert readiness.run_checks()["walls"] == "ok", "of an application that was told that they stand"
    assert replace(readiness, walls=Gate()).run_checks()["walls"] == "being tried"


@pytest.mark.parametrize(
    ("given", "then"),
    [
        ((1024, 524_288), (65_536, 524_288)),
        ((1024, 4096), (4096, 4096)),
        ((4096, 4096), None),
        ((100_000, 524_288), None),
    ],
)
def test_as_many_connections_as_the_machine_allows(
    given: tuple[int, int], then: tuple[int, int] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(serve.resource, "getrlimit", lambda _: given)
    monkeypatch.setattr(serve.resource, "setrlimit", lambda _, limits: asked.append(limits))
    serve._allow_many_connections()
    assert asked == ([] if then is None else [then])
