"""What Prometheus reads. It is computed when it is read: nothing of it stands between a student and their verdict.

Queue and verdicts are of the database: where several web processes share one, each tells the whole, and one is read.
Verdicts are those since this process began, looked for by when they ended; what a slow transaction commits late is
found by looking a little further back each time.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Iterator, Mapping
from datetime import datetime, timedelta
from typing import TYPE_CHECKING
from uuid import UUID

from server.base.counters import DROPPED_NOTIFICATIONS, REFUSED_LOGINS, TEMPLATE_RENEWALS
from server.database import Database, utc_now
from server.grading.supervisor import WorkerSupervisor
from server.health import repository
from server.health.event_counter import RENEWALS

if TYPE_CHECKING:
    from prometheus_client import CollectorRegistry, Histogram
    from prometheus_client.core import Metric

OVERLAP = timedelta(minutes=1)
SECONDS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 15.0, 60.0, 300.0)
WAITING, RUNNING = "waiting", "running"


class PrometheusMetrics:
    """For several threads."""

    def __init__(self, database: Database, supervisor: WorkerSupervisor) -> None:
        self._database, self._supervisor = database, supervisor
        self._walls: Mapping[str, bool] = {}
        self._since = utc_now()
        self._seen: dict[UUID, datetime] = {}
        self._reading = threading.Lock()
        self._registry: CollectorRegistry | None = None
        self._histograms: tuple[Histogram, Histogram] | None = None

    def set_walls(self, walls: Mapping[str, bool]) -> None:
        """The walls of the sandbox as they were probed: whether each stands."""
        self._walls = dict(walls)

    @property
    def walls(self) -> Mapping[str, bool]:
        return self._walls

    def render(self) -> tuple[bytes, str]:
        """The text that Prometheus reads, and its media type."""
        from prometheus_client.exposition import CONTENT_TYPE_LATEST, generate_latest

        with self._reading:
            registry = self._prepared()
            self._look(utc_now())
            return generate_latest(registry), CONTENT_TYPE_LATEST

    def _prepared(self) -> CollectorRegistry:
        """The library takes a tenth of a second to load: only where somebody reads."""
        if self._registry is None:
            from prometheus_client import CollectorRegistry, Histogram
            from prometheus_client.process_collector import ProcessCollector

            registry = CollectorRegistry()
            ProcessCollector(registry=registry)
            waited = "From sending to verdict, of first gradings", "From the beginning of a first grading to its end"
            names = "balise_verdict_seconds", "balise_grading_seconds"
            first, second = (
                Histogram(name, told, ["exercise", "outcome"], buckets=SECONDS, registry=registry)
                for name, told in zip(names, waited, strict=True)
            )
            registry.register(_Now(self))
            self._registry, self._histograms = registry, (first, second)
        return self._registry

    def _look(self, now: datetime) -> None:
        """Adds the verdicts that were not there the last time."""
        if self._histograms is None:
            raise RuntimeError("the histograms are not prepared")
        whole, graded = self._histograms
        with self._database.read() as db:
            found = repository.first_verdicts(db, self._since)
        for name, exercise, outcome, sent_at, started_at, finished_at in found:
            if name not in self._seen:
                self._seen[name] = finished_at
                whole.labels(exercise, outcome).observe((finished_at - sent_at).total_seconds())
                graded.labels(exercise, outcome).observe((finished_at - started_at).total_seconds())
        self._since = max(self._since, now - OVERLAP)
        self._seen = {name: when for name, when in self._seen.items() if when >= self._since}

    def collect(self) -> Iterator[Metric]:
        """What is read as it stands."""
        from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

        jobs = GaugeMetricFamily("balise_queue_jobs", "Jobs in the queue", labels=["kind", "state"])
        oldest = GaugeMetricFamily("balise_queue_oldest_seconds", "Age of the oldest job that waits", labels=["kind"])
        with self._database.read() as db:
            rows, renewals = repository.queue_depths(db), Counter(repository.counts_by_reason(db, RENEWALS))
        for kind, begun, count, since in rows:
            jobs.add_metric([kind, RUNNING if begun else WAITING], count)
            if not begun:
                oldest.add_metric([kind], max(0.0, (utc_now() - since).total_seconds()))
        yield jobs
        yield oldest
        yield GaugeMetricFamily("balise_workers", "Grading processes of this machine", self._supervisor.alive_count())
        walls = GaugeMetricFamily("balise_wall_standing", "Walls of the sandbox, as probed", labels=["wall"])
        for name, stands in self._walls.items():
            walls.add_metric([name], float(stands))
        yield walls
        elsewhere = {TEMPLATE_RENEWALS: renewals}
        for name, told, counted in COUNTERS:
            family = CounterMetricFamily(name, told, labels=["why"])
            for why, count in (Counter(counted.counts()) + elsewhere.get(counted, Counter())).items():
                family.add_metric([why], count)
            yield family


COUNTERS = (
    ("balise_refused_logins", "Log-ins and API tokens that were refused", REFUSED_LOGINS),
    ("balise_unposted", "What was not given to NATS, and is made up for later", DROPPED_NOTIFICATIONS),
    ("balise_template_renewals", "Templates of the sandbox that were replaced", TEMPLATE_RENEWALS),
)


class _Now:
    """A collector for the library: it asks when it is read."""

    def __init__(self, metrics: PrometheusMetrics) -> None:
        self._metrics = metrics

    def collect(self) -> Iterator[Metric]:
        return self._metrics.collect()

    def describe(self) -> list[Metric]:
        return []
