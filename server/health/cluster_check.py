"""What several machines share, looked at from one of them: database, NATS, clocks, and whether the work is taken.

It changes nothing: the services make what is missing when they start.
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
from server.database.migrate import WrongSchema, require_current
from server.health import repository
from server.queue import repository as jobs
from server.queue.jetstream.connection import NatsConnection, NatsUnavailableError
from server.queue.jetstream.stream_layout import STREAM, build_layout
from server.web.words import plural

ROUNDS = 20
#: Milliseconds of one question: slower than this, every verdict waits for it several times.
SLOW_DATABASE, SLOW_NATS = 10.0, 5.0
#: Seconds between two clocks.
ODD_CLOCK, WRONG_CLOCK = 1.0, 5.0
#: Connections to PostgreSQL that must be left.
FEW_CONNECTIONS = 20
CONNECT_SECONDS, ANSWER_SECONDS = 8.0, 5.0


class FindingLevel(Enum):
    good, doubtful, bad = range(3)


@dataclass(frozen=True)
class ClusterFinding:
    """What was looked at, how it is, and what to do where it is not well; in French."""

    level: FindingLevel
    subject: str
    message: str
    remedy: str = ""


def check_cluster(settings: Settings, lanes: Mapping[str, str]) -> Iterator[ClusterFinding]:
    """`lanes` as the engine's: see `server.queue.jetstream.stream_layout`."""
    found = list(_database(settings))
    yield from found
    if not settings.nats_url:
        yield ClusterFinding(
            FindingLevel.bad, "NATS", "aucun serveur n’est réglé", "réglez BALISE_NATS_URL, ici et partout ailleurs"
        )
        return
    with NatsConnection(settings, build_layout(settings, lanes), read_only=True) as connection:
        if not connection.wait_first_attempt(CONNECT_SECONDS):
            mend = "vérifiez BALISE_NATS_URL, le jeton ou la clé, les certificats, et que nats-server tourne"
            yield ClusterFinding(
                FindingLevel.bad, "NATS", f"injoignable : {connection.last_error or 'pas de réponse'}", mend
            )
            return
        yield from _nats(connection)
        if all(one.level is not FindingLevel.bad for one in found):
            yield from _work(settings, connection)


def _database(settings: Settings) -> Iterator[ClusterFinding]:
    about = "base de données"
    if not settings.on_postgres:
        yield ClusterFinding(
            FindingLevel.bad,
            about,
            "SQLite, un fichier de cette machine",
            "réglez BALISE_DATABASE_URL vers une base PostgreSQL, la même partout",
        )
        return
    with closing(Database(settings.url)) as database:
        try:
            yield _speed(about, "joignable", _database_rounds(database), SLOW_DATABASE)
            yield _secrecy(database)
            yield _room(database)
            yield _clock(database)
        except SQLAlchemyError as error:
            why = str(getattr(error, "orig", None) or error).splitlines()[0]
            yield ClusterFinding(FindingLevel.bad, about, f"injoignable : {why}", "vérifiez BALISE_DATABASE_URL")
            return
        try:
            require_current(database.engine)
            yield ClusterFinding(FindingLevel.good, "schéma", "celui de cette version de Balise")
        except WrongSchema as wrong:
            yield ClusterFinding(
                FindingLevel.bad, "schéma", str(wrong), "même version de Balise partout ; « balise serve » migre"
            )


def _database_rounds(database: Database) -> Iterator[float]:
    with database.read() as db:
        for _ in range(ROUNDS):
            begun = time.perf_counter()
            repository.ping(db)
            yield time.perf_counter() - begun


def _speed(about: str, told: str, rounds: Iterator[float], slow: float) -> ClusterFinding:
    taken = 1000.0 * statistics.median(rounds)
    if taken <= slow:
        return ClusterFinding(FindingLevel.good, about, f"{told}, répond en {_french(taken)} ms")
    mend = f"plus de {_french(slow)} ms : rapprochez les machines, ou allégez celle qui répond"
    return ClusterFinding(FindingLevel.doubtful, about, f"{told}, mais lente : {_french(taken)} ms", mend)


def _french(number: float) -> str:
    return f"{number:.2f}".replace(".", ",")


def _secrecy(database: Database) -> ClusterFinding:
    with database.read() as db:
        coded = repository.is_encrypted(db)
    told = "chiffrée (TLS)" if coded else "en clair"
    mend = "" if coded else "sur un réseau partagé, ajoutez ?sslmode=verify-full à BALISE_DATABASE_URL"
    return ClusterFinding(FindingLevel.good, "connexion à la base", told, mend)


def _room(database: Database) -> ClusterFinding:
    """PostgreSQL refuses who comes when it is full, in the middle of an exam rather than before it."""
    with database.read() as db:
        opened, most = repository.connection_usage(db)
    told = f"{plural(opened, 'ouverte', 'ouvertes')}, {most} au plus"
    if opened + FEW_CONNECTIONS <= most:
        return ClusterFinding(FindingLevel.good, "connexions à la base", told)
    mend = (
        f"augmentez max_connections : {MAX_CONNECTIONS} pour chaque serveur web, 3 pour chaque correcteur (ou placez "
        "PgBouncer devant PostgreSQL)"
    )
    return ClusterFinding(FindingLevel.doubtful, "connexions à la base", told, mend)


def _clock(database: Database) -> ClusterFinding:
    """The database's clock ends leases; those of the machines date what is sent."""
    with database.read() as db:
        jobs.current_time(db)
        before = utc_now()
        there = jobs.current_time(db)
        apart = abs((there - before - (utc_now() - before) / 2).total_seconds())
    if apart < ODD_CLOCK:
        return ClusterFinding(
            FindingLevel.good, "horloges", f"celle d’ici et celle de la base diffèrent de {_french(1000 * apart)} ms"
        )
    level = FindingLevel.bad if apart >= WRONG_CLOCK else FindingLevel.doubtful
    mend = "mettez toutes les machines à l’heure (chrony, systemd-timesyncd)"
    return ClusterFinding(level, "horloges", f"{_french(apart)} s entre celle d’ici et celle de la base", mend)


def _nats(connection: NatsConnection) -> Iterator[ClusterFinding]:
    def asked() -> list[float]:
        async def rounds() -> list[float]:
            taken = []
            for _ in range(ROUNDS):
                begun = time.perf_counter()
                await connection.client.flush()
                taken.append(time.perf_counter() - begun)
            return taken

        return connection.run_blocking(rounds, ANSWER_SECONDS)

    try:
        yield _speed("NATS", f"joignable (version {connection.server_version})", iter(asked()), SLOW_NATS)
        yield from _stream(connection)
    except NatsUnavailableError as down:
        yield ClusterFinding(
            FindingLevel.bad, "JetStream", f"ne répond pas : {down}", "activez JetStream dans nats-server (« -js »)"
        )


def _stream(connection: NatsConnection) -> Iterator[ClusterFinding]:
    connection.run_blocking(connection.jetstream.account_info, ANSWER_SECONDS)
    yield ClusterFinding(FindingLevel.good, "JetStream", "activé")
    amiss = connection.run_blocking(lambda: connection.layout.find_differences(connection.jetstream), ANSWER_SECONDS)
    for told in amiss:
        yield ClusterFinding(FindingLevel.bad, "flux", told, "redémarrez « balise serve », qui le met en place")
    if amiss:
        return
    info = connection.run_blocking(lambda: connection.jetstream.stream_info(STREAM), ANSWER_SECONDS)
    yield ClusterFinding(
        FindingLevel.good,
        "flux",
        f"« {STREAM} » et ses consommateurs sont en place, {plural(info.state.messages, 'ticket', 'tickets')}",
    )
    replicas = (info.cluster.replicas or []) if info.cluster else []
    lagging = [one.name for one in replicas if one.offline or not one.current]
    if lagging:
        told = f"copies en retard ou absentes : {', '.join(map(str, lagging))}"
        yield ClusterFinding(FindingLevel.doubtful, "flux", told, "regardez les nœuds de NATS nommés")


def _work(settings: Settings, connection: NatsConnection) -> Iterator[ClusterFinding]:
    desk = connection.layout.consumers[0]
    with closing(Database(settings.url)) as database, database.read() as db:
        refused, begun, waiting = jobs.count_refused_by_version(db), jobs.count_running(db), jobs.count_waiting(db)
    for needs, count in refused.items():
        waits = plural(count, "travail attend", "travaux attendent")
        told = f"{waits} un correcteur de {needs.replace('@', ', version ')}"
        mend = f"démarrez-en un de cette version ; au bout de {settings.version_seconds:g} s, n’importe lequel le prend"
        yield ClusterFinding(FindingLevel.doubtful, "versions", told, mend)
    try:
        idle = connection.run_blocking(
            lambda: connection.jetstream.consumer_info(STREAM, desk.consumer_name), ANSWER_SECONDS
        )
    except NatsUnavailableError:
        return  # told above
    free = idle.num_waiting or 0
    told = f"{plural(free, 'libre', 'libres')}, {plural(begun, 'travail', 'travaux')} en cours, {waiting} en attente"
    if free or begun:
        yield ClusterFinding(FindingLevel.good, "correcteurs", told)
    else:
        yield ClusterFinding(
            FindingLevel.doubtful, "correcteurs", f"aucun : {told}", "démarrez « balise worker », ou BALISE_WORKERS"
        )
