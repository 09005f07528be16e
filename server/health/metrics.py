"""Metrics for Prometheus, computed as they are read: none of it delays a verdict.

Queue and verdicts come from the database: each of several web processes reports all of them, and one is scraped.
Verdicts are those since this process started, found by when they ended; each read overlaps the last one, so that slow
commits are not missed.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Iterator, Mapping
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import UUID

from server.base.counters import DROPPED_NOTIFICATIONS, REFUSED_LOGINS, TEMPLATE_RENEWALS
from server.base.files import free_bytes
from server.database import Database, utc_now
from server.grading.supervisor import WorkerSupervisor
from server.health import repository
from server.health.event_counter import RENEWALS

if TYPE_CHECKING:
    from prometheus_client import CollectorRegistry, Histogram
    from prometheus_client.core import Metric

OVERLAP = timedelta(minutes=1)
BUCKETS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 15.0, 60.0, 300.0)
WAITING, RUNNING = "waiting", "running"


class PrometheusMetrics:
    """Thread-safe."""

    def __init__(self, database: Database, supervisor: WorkerSupervisor, data_dir: Path) -> None:
        self._database, self._supervisor, self._data_dir = database, supervisor, data_dir
        self._walls: Mapping[str, bool] = {}
        self._last_read = utc_now()
        self._observed: dict[UUID, datetime] = {}
        self._lock = threading.Lock()
        self._registry: CollectorRegistry | None = None
        self._histograms: tuple[Histogram, Histogram] | None = None

    def set_wall_states(self, walls: Mapping[str, bool]) -> None:
        """Set the probed walls of the sandbox: whether each stands."""
        self._walls = dict(walls)

    @property
    def wall_states(self) -> Mapping[str, bool]:
        return self._walls

    def render(self) -> tuple[bytes, str]:
        """Return the text that Prometheus reads, and its media type."""
        from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest

        with self._lock:
            registry = self._create_registry_once()
            self._observe_new_verdicts(utc_now())
            return generate_latest(registry), CONTENT_TYPE_LATEST

    def _create_registry_once(self) -> CollectorRegistry:
        """Create the registry at the first read: the library takes 0.1 s to load."""
        if self._registry is None:
            from prometheus_client import CollectorRegistry, Histogram
            from prometheus_client.process_collector import ProcessCollector

            registry = CollectorRegistry()
            ProcessCollector(registry=registry)
            descriptions = (
                "From sending to verdict, of first gradings",
                "From the beginning of a first grading to its end",
            )
            names = "balise_verdict_seconds", "balise_grading_seconds"
            first, second = (
                Histogram(name, description, ["exercise", "outcome"], buckets=BUCKETS, registry=registry)
                for name, description in zip(names, descriptions, strict=True)
            )
            registry.register(_CurrentValuesCollector(self))
            self._registry, self._histograms = registry, (first, second)
        return self._registry

    def _observe_new_verdicts(self, now: datetime) -> None:
        """Observe the verdicts that are new since the last read."""
        if self._histograms is None:
            raise RuntimeError("the histograms are not prepared")
        whole, graded = self._histograms
        with self._database.read() as db:
            verdicts = repository.load_first_gradings_since(db, self._last_read)
        for name, exercise, outcome, sent_at, started_at, finished_at in verdicts:
            if name not in self._observed:
                self._observed[name] = finished_at
                whole.labels(exercise, outcome).observe((finished_at - sent_at).total_seconds())
                graded.labels(exercise, outcome).observe((finished_at - started_at).total_seconds())
        self._last_read = max(self._last_read, now - OVERLAP)
        self._observed = {name: when for name, when in self._observed.items() if when >= self._last_read}

    def collect_current_values(self) -> Iterator[Metric]:
        """Yield the current values."""
        from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

        jobs = GaugeMetricFamily("balise_queue_jobs", "Jobs in the queue", labels=["kind", "state"])
        oldest = GaugeMetricFamily("balise_queue_oldest_seconds", "Age of the oldest job that waits", labels=["kind"])
        with self._database.read() as db:
            rows, renewals = repository.load_queue_depths(db), Counter(repository.load_counts_by_reason(db, RENEWALS))
        for kind, running, count, since in rows:
            jobs.add_metric([kind, RUNNING if running else WAITING], count)
            if not running:
                oldest.add_metric([kind], max(0.0, (utc_now() - since).total_seconds()))
        yield jobs
        yield oldest
        yield GaugeMetricFamily(
            "balise_workers", "Grading processes of this machine", self._supervisor.alive_worker_count()
        )
        yield GaugeMetricFamily("balise_disk_free_bytes", "Room on the disk of the data", free_bytes(self._data_dir))
        walls = GaugeMetricFamily("balise_wall_standing", "Walls of the sandbox, as probed", labels=["wall"])
        for name, stands in self._walls.items():
            walls.add_metric([name], float(stands))
        yield walls
        remote_counts = {TEMPLATE_RENEWALS: renewals}
        for name, description, counted in COUNTERS:
            family = CounterMetricFamily(name, description, labels=["why"])
            for why, count in (Counter(counted.counts()) + remote_counts.get(counted, Counter())).items():
                family.add_metric([why], count)
            yield family


COUNTERS = (
    ("balise_refused_logins", "Log-ins and API tokens that were refused", REFUSED_LOGINS),
    ("balise_unposted", "What was not given to NATS, and is made up for later", DROPPED_NOTIFICATIONS),
    ("balise_template_renewals", "Templates of the sandbox that were replaced", TEMPLATE_RENEWALS),
)


class _CurrentValuesCollector:
    """A collector for the library, which reads current values."""

    def __init__(self, metrics: PrometheusMetrics) -> None:
        self._metrics = metrics

    def collect(self) -> Iterator[Metric]:
        return self._metrics.collect_current_values()

    def describe(self) -> list[Metric]:
        return []
