"""The trace of a submission, from its request to its verdict, for whoever collects OpenTelemetry.

Off unless the standard variables ask for it (`OTEL_TRACES_EXPORTER`, or the address of a collector); what is off costs
the look at one name, and loads nothing. The provider is our own, and not the global one: libraries that would tell
addresses, which hold one-time links, or what is sent, find none.

What is told is names of ours, counts and times: neither code nor answers, nor who sends, nor from where.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping, MutableMapping
from contextlib import contextmanager
from threading import Lock
from typing import TYPE_CHECKING, Any

from cachetools import TTLCache

if TYPE_CHECKING:
    from opentelemetry.context import Context
    from opentelemetry.sdk.trace import TracerProvider
    from opentelemetry.trace import Span, Tracer

#: Where a job's payload keeps its trace, and since when it waits (nanoseconds since 1970).
TRACE, PUT_AT = "traceparent", "put_at"
NAME = "balise"
MILLISECOND = 1_000_000  # nanoseconds
OTLP, CONSOLE = "otlp", "console"
WANTED = ("OTEL_TRACES_EXPORTER", "OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT")
PROTOCOLS = ("OTEL_EXPORTER_OTLP_TRACES_PROTOCOL", "OTEL_EXPORTER_OTLP_PROTOCOL")
HTTP = "http/protobuf"
MINUTES = 600.0

Attributes = Mapping[str, str | int | float | bool]


class TracingConfigurationError(Exception):
    """The variables ask for what cannot be had; its message is French and for the administrator."""


class _TracingState:
    """Of this process. `sent` holds the traces of what it has put in the queue, until its news are told."""

    provider: TracerProvider | None = None
    tracer: Tracer | None = None
    sent: MutableMapping[str, str] = TTLCache(4096, MINUTES)
    lock = Lock()


def is_requested(environment: Mapping[str, str]) -> bool:
    """Whether the standard variables ask for traces."""
    off = environment.get("OTEL_SDK_DISABLED", "").strip().lower() == "true"
    exporter = environment.get("OTEL_TRACES_EXPORTER", "").strip().lower()
    return not off and exporter != "none" and any(environment.get(name, "").strip() for name in WANTED)


def start_tracing(process: str) -> None:
    """What a process does first; `process` is its part in the service. Raises TracingConfigurationError."""
    if not is_requested(os.environ):
        return
    try:
        from opentelemetry.sdk.resources import Resource
        from opentelemetry.sdk.trace import TracerProvider
        from opentelemetry.sdk.trace.export import BatchSpanProcessor
    except ImportError as missing:
        raise TracingConfigurationError(
            "les traces demandent des paquets de plus, que pip install 'balise[traces]' installe "
            "(ou ne réglez pas les variables OTEL_…)"
        ) from missing
    exporter = _create_exporter()
    here = {"service.name": os.environ.get("OTEL_SERVICE_NAME") or NAME, "service.instance.id": process}
    provider = TracerProvider(resource=Resource.create(here))
    provider.add_span_processor(BatchSpanProcessor(exporter))
    set_provider(provider)


def _create_exporter() -> Any:
    name = os.environ.get("OTEL_TRACES_EXPORTER", OTLP).strip().lower() or OTLP
    if name == CONSOLE:
        from opentelemetry.sdk.trace.export import ConsoleSpanExporter

        return ConsoleSpanExporter()
    protocol = next((value for key in PROTOCOLS if (value := os.environ.get(key, "").strip())), HTTP)
    if name != OTLP or protocol != HTTP:
        raise TracingConfigurationError(
            f"les traces partent par otlp, en {HTTP}, ou vers console : ni OTEL_TRACES_EXPORTER={name}, ni {protocol}"
        )
    from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter

    return OTLPSpanExporter()


def set_provider(provider: TracerProvider | None) -> None:
    """Sends what is traced from now on there; None: nowhere."""
    _TracingState.provider = provider
    _TracingState.tracer = None if provider is None else provider.get_tracer(NAME)
    _TracingState.sent.clear()


def stop_tracing() -> None:
    """Sends what has not left yet."""
    if _TracingState.provider is not None:
        _TracingState.provider.shutdown()
        set_provider(None)


@contextmanager
def request_span(method: str, parent: str = "") -> Iterator[Any]:
    """The span of a request, which is the root of its trace, or below a `parent` that a trusted proxy tells."""
    if _TracingState.tracer is None:
        yield None
        return
    from opentelemetry.context import Context
    from opentelemetry.trace import SpanKind

    above = _context_below(parent) if parent else Context()
    attributes = {"http.request.method": method}
    with _span(_TracingState.tracer, method, context=above, kind=SpanKind.SERVER, attributes=attributes) as span:
        yield span


@contextmanager
def _span(tracer: Tracer, name: str, **how: Any) -> Iterator[Span]:
    """The current span within. That something was raised is told, and not what it says, which may be what was sent."""
    from opentelemetry.trace import StatusCode

    how |= {"record_exception": False, "set_status_on_exception": False}
    with tracer.start_as_current_span(name, **how) as span:
        try:
            yield span
        except Exception:
            span.set_status(StatusCode.ERROR)
            raise


def record_response(span: Span | None, method: str, route: str, status: int) -> None:
    """By its route, since its address may hold a one-time link."""
    if span is None:
        return
    span.update_name(f"{method} {route}".rstrip())
    span.set_attribute("http.route", route)
    span.set_attribute("http.response.status_code", status)
    if status >= 500:
        from opentelemetry.trace import StatusCode

        span.set_status(StatusCode.ERROR)


@contextmanager
def span(name: str, **attributes: str | int) -> Iterator[None]:
    """A part of what is being traced; nothing where nothing is."""
    if _TracingState.tracer is None or not _is_being_traced():
        yield
        return
    with _span(_TracingState.tracer, name, attributes=attributes):
        yield


def record_spans(began: int, milliseconds: Mapping[str, float]) -> None:
    """Parts that have been timed, one after the other since `began` (nanoseconds)."""
    if _TracingState.tracer is None or not _is_being_traced():
        return
    for name, taken in milliseconds.items():
        ended = began + round(taken * MILLISECOND)
        _TracingState.tracer.start_span(name, start_time=began).end(ended)
        began = ended


def _is_being_traced() -> bool:
    from opentelemetry.trace import get_current_span

    return get_current_span().get_span_context().is_valid


def job_trace_fields(key: str) -> dict[str, str | int]:
    """What a job put now takes along, for whoever does it: its trace. `key` is how its news will be told."""
    if _TracingState.tracer is None or not _is_being_traced():
        return {}
    from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator

    carrier: dict[str, str] = {}
    TraceContextTextMapPropagator().inject(carrier)
    with _TracingState.lock:
        _TracingState.sent[key] = carrier[TRACE]
    return {TRACE: carrier[TRACE], PUT_AT: time.time_ns()}


@contextmanager
def job_span(payload: Mapping[str, Any], kind: str, tries: int, leased_since: int) -> Iterator[None]:
    """The work on a job, in the trace that it takes along: how long it waited, its lease, then what is done within."""
    parent = payload.get(TRACE)
    if _TracingState.tracer is None or not isinstance(parent, str):
        yield
        return
    from opentelemetry.trace import SpanKind

    above, put_at, now = _context_below(parent), payload.get(PUT_AT), time.time_ns()
    if isinstance(put_at, int):
        _TracingState.tracer.start_span("wait", above, start_time=put_at).end(max(put_at, leased_since))
    _TracingState.tracer.start_span("lease", above, start_time=leased_since).end(now)
    told: Attributes = {"job.kind": kind, "job.tries": tries}
    with _span(_TracingState.tracer, kind, context=above, kind=SpanKind.CONSUMER, attributes=told):
        yield


def record_notification(key: str, since: int) -> None:
    """That the end of a job which this process has put was told to who waits for it, heard of at `since`."""
    if _TracingState.tracer is None:
        return
    with _TracingState.lock:
        parent = _TracingState.sent.pop(key, None)
    if parent is not None:
        _TracingState.tracer.start_span("event", _context_below(parent), start_time=since).end()


def _context_below(parent: str) -> Context:
    from opentelemetry.context import Context
    from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator

    return TraceContextTextMapPropagator().extract({TRACE: parent}, Context())
