"""Check of what several machines share, from one of them: database, NATS, clocks, workers.

It changes nothing: the services create what is missing when they start.
"""

import statistics
import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from enum import Enum

from sqlalchemy.exc import SQLAlchemyError

from server.base.settings import Settings
from server.database import MAX_CONNECTIONS, Database, utc_now
from server.database.migrate import WrongSchemaError, require_current_schema
from server.health import repository
from server.queue import repository as jobs
from server.queue.jetstream.connection import NatsConnection, NatsUnavailableError
from server.queue.jetstream.stream_layout import STREAM, build_layout
from server.web.words import count_with_noun

PINGS = 20
#: Latency in milliseconds above which every verdict is noticeably delayed.
SLOW_DATABASE_MS, SLOW_NATS_MS = 10.0, 5.0
#: Difference of two clocks in seconds.
CLOCK_WARNING_SECONDS, CLOCK_ERROR_SECONDS = 1.0, 5.0
#: Connections to PostgreSQL that must be left.
MIN_SPARE_CONNECTIONS = 20
CONNECT_SECONDS, ANSWER_SECONDS = 8.0, 5.0


class FindingLevel(Enum):
    good, doubtful, bad = range(3)


@dataclass(frozen=True)
class ClusterFinding:
    """A checked subject, its state, and the remedy where it is not well; in French."""

    level: FindingLevel
    subject: str
    message: str
    remedy: str = ""


def check_cluster(settings: Settings, lanes: Mapping[str, str]) -> Iterator[ClusterFinding]:
    """Yield findings; `lanes` as in `server.queue.jetstream.stream_layout`."""
    database_findings = list(_check_database(settings))
    yield from database_findings
    if not settings.nats_url:
        yield ClusterFinding(
            FindingLevel.bad, "NATS", "aucun serveur n’est réglé", "réglez BALISE_NATS_URL, ici et partout ailleurs"
        )
        return
    with NatsConnection(settings, build_layout(settings, lanes), read_only=True) as connection:
        if not connection.wait_first_attempt(CONNECT_SECONDS):
            remedy = "vérifiez BALISE_NATS_URL, le jeton ou la clé, les certificats, et que nats-server tourne"
            yield ClusterFinding(
                FindingLevel.bad, "NATS", f"injoignable : {connection.last_error or 'pas de réponse'}", remedy
            )
            return
        yield from _check_nats(connection)
        if all(finding.level is not FindingLevel.bad for finding in database_findings):
            yield from _check_workers(settings, connection)


def _check_database(settings: Settings) -> Iterator[ClusterFinding]:
    subject = "base de données"
    if not settings.on_postgres:
        yield ClusterFinding(
            FindingLevel.bad,
            subject,
            "SQLite, un fichier de cette machine",
            "réglez BALISE_DATABASE_URL vers une base PostgreSQL, la même partout",
        )
        return
    with closing(Database(settings.sqlalchemy_url)) as database:
        try:
            yield _check_latency(subject, "joignable", _time_database_pings(database), SLOW_DATABASE_MS)
            yield _check_encryption(database)
            yield _check_connections(database)
            yield _check_clock(database)
        except SQLAlchemyError as error:
            why = str(getattr(error, "orig", None) or error).splitlines()[0]
            yield ClusterFinding(FindingLevel.bad, subject, f"injoignable : {why}", "vérifiez BALISE_DATABASE_URL")
            return
        try:
            require_current_schema(database.engine)
            yield ClusterFinding(FindingLevel.good, "schéma", "celui de cette version de Balise")
        except WrongSchemaError as wrong:
            yield ClusterFinding(
                FindingLevel.bad, "schéma", str(wrong), "même version de Balise partout ; « balise serve » migre"
            )


def _time_database_pings(database: Database) -> Iterator[float]:
    with database.read() as db:
        for _ in range(PINGS):
            started = time.perf_counter()
            repository.ping_database(db)
            yield time.perf_counter() - started


def _check_latency(subject: str, message: str, durations: Iterator[float], slow: float) -> ClusterFinding:
    milliseconds = 1000.0 * statistics.median(durations)
    if milliseconds <= slow:
        return ClusterFinding(FindingLevel.good, subject, f"{message}, répond en {_format_french(milliseconds)} ms")
    remedy = f"plus de {_format_french(slow)} ms : rapprochez les machines, ou allégez celle qui répond"
    return ClusterFinding(
        FindingLevel.doubtful, subject, f"{message}, mais lente : {_format_french(milliseconds)} ms", remedy
    )


def _format_french(number: float) -> str:
    return f"{number:.2f}".replace(".", ",")


def _check_encryption(database: Database) -> ClusterFinding:
    with database.read() as db:
        encrypted = repository.is_connection_encrypted(db)
    message = "chiffrée (TLS)" if encrypted else "en clair"
    remedy = "" if encrypted else "sur un réseau partagé, ajoutez ?sslmode=verify-full à BALISE_DATABASE_URL"
    return ClusterFinding(FindingLevel.good, "connexion à la base", message, remedy)


def _check_connections(database: Database) -> ClusterFinding:
    """A full PostgreSQL refuses connections, in the middle of a test rather than before it."""
    with database.read() as db:
        opened, limit = repository.count_open_and_allowed_connections(db)
    message = f"{count_with_noun(opened, 'ouverte', 'ouvertes')}, {limit} au plus"
    if opened + MIN_SPARE_CONNECTIONS <= limit:
        return ClusterFinding(FindingLevel.good, "connexions à la base", message)
    remedy = (
        f"augmentez max_connections : {MAX_CONNECTIONS} pour chaque serveur web, 3 pour chaque correcteur (ou placez "
        "PgBouncer devant PostgreSQL)"
    )
    return ClusterFinding(FindingLevel.doubtful, "connexions à la base", message, remedy)


def _check_clock(database: Database) -> ClusterFinding:
    """The database's clock times the leases; the machines' clocks date submissions."""
    with database.read() as db:
        jobs.current_time(db)
        before = utc_now()
        database_time = jobs.current_time(db)
        difference = abs((database_time - before - (utc_now() - before) / 2).total_seconds())
    if difference < CLOCK_WARNING_SECONDS:
        return ClusterFinding(
            FindingLevel.good,
            "horloges",
            f"celle d’ici et celle de la base diffèrent de {_format_french(1000 * difference)} ms",
        )
    level = FindingLevel.bad if difference >= CLOCK_ERROR_SECONDS else FindingLevel.doubtful
    remedy = "mettez toutes les machines à l’heure (chrony, systemd-timesyncd)"
    return ClusterFinding(
        level, "horloges", f"{_format_french(difference)} s entre celle d’ici et celle de la base", remedy
    )


def _check_nats(connection: NatsConnection) -> Iterator[ClusterFinding]:
    def flush_durations() -> list[float]:
        async def time_flushes() -> list[float]:
            durations = []
            for _ in range(PINGS):
                started = time.perf_counter()
                await connection.connected_client.flush()
                durations.append(time.perf_counter() - started)
            return durations

        return connection.run_blocking(time_flushes, ANSWER_SECONDS)

    try:
        yield _check_latency(
            "NATS", f"joignable (version {connection.server_version})", iter(flush_durations()), SLOW_NATS_MS
        )
        yield from _check_jetstream(connection)
    except NatsUnavailableError as down:
        yield ClusterFinding(
            FindingLevel.bad, "JetStream", f"ne répond pas : {down}", "activez JetStream dans nats-server (« -js »)"
        )


def _check_jetstream(connection: NatsConnection) -> Iterator[ClusterFinding]:
    connection.run_blocking(connection.jetstream.account_info, ANSWER_SECONDS)
    yield ClusterFinding(FindingLevel.good, "JetStream", "activé")
    differences = connection.run_blocking(
        lambda: connection.layout.find_differences(connection.jetstream), ANSWER_SECONDS
    )
    for message in differences:
        yield ClusterFinding(FindingLevel.bad, "flux", message, "redémarrez « balise serve », qui le met en place")
    if differences:
        return
    info = connection.run_blocking(lambda: connection.jetstream.stream_info(STREAM), ANSWER_SECONDS)
    yield ClusterFinding(
        FindingLevel.good,
        "flux",
        f"« {STREAM} » et ses consommateurs sont en place, {count_with_noun(info.state.messages, 'ticket', 'tickets')}",
    )
    replicas = (info.cluster.replicas or []) if info.cluster else []
    lagging = [replica.name for replica in replicas if replica.offline or not replica.current]
    if lagging:
        message = f"copies en retard ou absentes : {', '.join(map(str, lagging))}"
        yield ClusterFinding(FindingLevel.doubtful, "flux", message, "regardez les nœuds de NATS nommés")


def _check_workers(settings: Settings, connection: NatsConnection) -> Iterator[ClusterFinding]:
    consumer = connection.layout.consumers[0]
    with closing(Database(settings.sqlalchemy_url)) as database, database.read() as db:
        refused, running, waiting = jobs.count_refused_by_version(db), jobs.count_running(db), jobs.count_waiting(db)
    for needs, count in refused.items():
        waits = count_with_noun(count, "travail attend", "travaux attendent")
        message = f"{waits} un correcteur de {needs.replace('@', ', version ')}"
        remedy = (
            f"démarrez-en un de cette version ; au bout de {settings.version_seconds:g} s, n’importe lequel le prend"
        )
        yield ClusterFinding(FindingLevel.doubtful, "versions", message, remedy)
    try:
        consumer_info = connection.run_blocking(
            lambda: connection.jetstream.consumer_info(STREAM, consumer.consumer_name), ANSWER_SECONDS
        )
    except NatsUnavailableError:
        return  # reported above
    idle_count = consumer_info.num_waiting or 0
    running_jobs = count_with_noun(running, "travail", "travaux")
    message = f"{count_with_noun(idle_count, 'libre', 'libres')}, {running_jobs} en cours, {waiting} en attente"
    if idle_count or running:
        yield ClusterFinding(FindingLevel.good, "correcteurs", message)
    else:
        yield ClusterFinding(
            FindingLevel.doubtful, "correcteurs", f"aucun : {message}", "démarrez « balise worker », ou BALISE_WORKERS"
        )
