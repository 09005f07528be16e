"""A submission is traced from its request to its verdict, across the queue, where it is asked for; nothing else is."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator

import pytest
from opentelemetry.sdk.trace import ReadableSpan, TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import StatusCode
from sqlalchemy import select

from server.base import traces
from server.base.files import ROOT
from server.base.middleware import RequestLogMiddleware
from server.cli import main
from server.queue.models import Job
from tests.support.service import Site

SECRET = "x = 'le code de Bob'\n"


@pytest.fixture
def told() -> Iterator[InMemorySpanExporter]:
    """What is traced meanwhile."""
    exporter, provider = InMemorySpanExporter(), TracerProvider()
    provider.add_span_processor(SimpleSpanProcessor(exporter))
    traces.set_provider(provider)
    yield exporter
    traces.set_provider(None)


def tree(spans: tuple[ReadableSpan, ...]) -> set[tuple[str, str]]:
    """Each span with the one above it."""
    names = {span.context.span_id: span.name for span in spans}
    return {(span.name, names.get(span.parent.span_id, "?") if span.parent else "") for span in spans}


def test_a_submission_is_one_trace_from_its_request_to_its_verdict(site: Site, told: InMemorySpanExporter) -> None:
    headers = site.token()
    told.clear()
    stored = site.submit(headers, SECRET)
    assert site.worker.run_one()
    site.client.get(f"{stored['url']}/events", headers=headers)
    spans = told.get_finished_spans()
    root = next(span for span in spans if span.name == "POST /api/v1/submissions")
    traced = tuple(span for span in spans if span.context.trace_id == root.context.trace_id)
    above = "POST /api/v1/submissions"
    assert tree(traced) == {
        (above, ""), ("commit", above), ("wait", above), ("lease", above), ("grade", above),
        ("run", "grade"), ("record", "grade"), ("commit", "record"), ("event", above),
    }  # fmt: skip
    by_name = {span.name: span for span in traced}
    order = [by_name[name].start_time for name in (above, "wait", "lease", "grade", "run", "record", "event")]
    assert order == sorted(order)
    assert dict(root.attributes or {}) == {
        "http.request.method": "POST", "http.route": "/api/v1/submissions", "http.response.status_code": 202,
    }  # fmt: skip
    written = json.dumps([json.loads(span.to_json()) for span in spans])
    assert all(secret not in written for secret in ("Bob", "Bearer", "testclient", "192.0.2", headers["Authorization"]))


def test_the_parts_of_a_grading_are_those_that_its_verdict_times(told: InMemorySpanExporter) -> None:
    with traces.request_span("POST"):
        traces.record_spans(1_000, {"checks": 2.0, "diagnosis": 0.5})
    first, second, _ = told.get_finished_spans()
    assert [(one.name, one.start_time, one.end_time) for one in (first, second)] == [
        ("checks", 1_000, 2_001_000), ("diagnosis", 2_001_000, 2_501_000),
    ]  # fmt: skip


def test_a_request_is_told_by_its_route_and_follows_a_trusted_proxy_alone(
    site: Site, told: InMemorySpanExporter, monkeypatch: pytest.MonkeyPatch
) -> None:
    theirs = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
    for proxied in (False, True):
        told.clear()
        trail = next(one for one in site.app.user_middleware if one.cls is RequestLogMiddleware)
        monkeypatch.setitem(trail.kwargs, "proxied", proxied)
        middle = RequestLogMiddleware(site.app.router, proxied)
        monkeypatch.setattr(site.app, "middleware_stack", middle)
        site.client.get("/bienvenue/balise_un-secret", headers={traces.TRACE: theirs})
        (span, *_) = [one for one in told.get_finished_spans() if one.name.startswith("GET")]
        assert span.name == "GET /bienvenue/{token}"
        assert (f"{span.context.trace_id:032x}" == theirs.split("-")[1]) is proxied
        assert "un-secret" not in span.to_json()


def test_what_fails_is_told_without_what_it_says(told: InMemorySpanExporter) -> None:
    payload = {traces.TRACE: "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"}
    within = [
        lambda: traces.request_span("GET"),
        lambda: traces.job_span(payload, "grade", 1, 1_000),
        lambda: traces.span("run"),
    ]
    for first, second in ((within[0], within[2]), (within[1], within[2])):
        with pytest.raises(ValueError, match="Bob"), first(), second():
            raise ValueError(SECRET)
    spans = told.get_finished_spans()
    failed = [span.name for span in spans if span.status.status_code is StatusCode.ERROR]
    assert failed == ["run", "GET", "run", "grade"]
    assert all("Bob" not in span.to_json() for span in spans)


def test_nothing_is_traced_nor_loaded_unless_it_is_asked_for(site: Site) -> None:
    site.submit(site.token())
    with site.database.read() as db:
        payload = db.execute(select(Job.payload)).scalars().one()
    assert traces.TRACE not in payload
    line = (
        "import sys; from server.base import traces; traces.start_tracing('web');"
        "from server.queue import worker, service;"
        "assert not [name for name in sys.modules if name.startswith('opentelemetry')]"
    )
    subprocess.run([sys.executable, "-c", line], check=True, cwd=ROOT)


COLLECTOR = {"OTEL_EXPORTER_OTLP_ENDPOINT": "http://127.0.0.1:4318"}
ASKED = [
    ({}, False),
    (COLLECTOR, True),
    ({"OTEL_TRACES_EXPORTER": "otlp"}, True),
    ({"OTEL_EXPORTER_OTLP_TRACES_ENDPOINT": "http://c/v1/traces"}, True),
    ({**COLLECTOR, "OTEL_TRACES_EXPORTER": "none"}, False),
    ({**COLLECTOR, "OTEL_SDK_DISABLED": "true"}, False),
    ({"OTEL_SERVICE_NAME": "balise"}, False),
]


@pytest.mark.parametrize(("environment", "asked"), ASKED)
def test_the_standard_variables_say_whether(environment: dict[str, str], asked: bool) -> None:
    assert traces.is_requested(environment) is asked


def test_what_cannot_be_traced_is_told_in_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: object
) -> None:
    monkeypatch.setenv("OTEL_TRACES_EXPORTER", "otlp")
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_PROTOCOL", "grpc")
    assert main(["serve", "--port", "0", "--data", str(tmp_path)]) == 2
    assert "http/protobuf" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "opentelemetry.sdk.trace", None)
    with pytest.raises(traces.TracingConfigurationError, match=r"balise\[traces\]"):
        traces.start_tracing("web")


def test_a_collector_gets_them_as_the_variables_say(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OTEL_TRACES_EXPORTER", "console")
    monkeypatch.setenv("OTEL_RESOURCE_ATTRIBUTES", "deployment.environment=lycée")
    traces.start_tracing("web")
    try:
        provider = traces._TracingState.provider
        assert provider is not None
        attributes = provider.resource.attributes
        assert (attributes["service.name"], attributes["service.instance.id"]) == ("balise", "web")
        assert attributes["deployment.environment"] == "lycée"
    finally:
        traces.stop_tracing()
    assert traces._TracingState.tracer is None
