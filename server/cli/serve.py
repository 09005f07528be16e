"""`balise serve`: the whole service on embedded defaults."""

import errno
import gc
import logging
import resource
import signal
import socket
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread
from types import FrameType

import uvicorn
from fastapi import FastAPI
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from server.app import create_app
from server.backup.archive import BackupError
from server.backup.service import back_up_before_upgrade
from server.base import http_protocol, logs, traces
from server.base.app_services import get_service
from server.base.concurrency import Gate
from server.base.settings import Settings
from server.cli import CommandError
from server.cli.configuration import read_settings, start_tracing_or_fail
from server.cli.data_lock import lock_data_folder
from server.cli.database import database_problem
from server.cli.sandboxes import Probing, require_safe_sandbox, start_probing_walls
from server.course import Course, load_course
from server.course.start_cache import CACHE_FILE, StartCache
from server.database import STARTUP_TIMEOUT, Database, is_unavailable, utc_now
from server.database.migrate import WrongSchemaError, upgrade
from server.figures.service import FigureService
from server.grading.supervisor import WorkerSupervisor
from server.health.metrics import PrometheusMetrics
from server.identity import links
from server.reading.ahead import preload_course
from server.sandbox import WallStatus, is_safe_to_serve
from server.submissions.job_events import JobEvents
from server.tables import TABLE_NAMES

log = logging.getLogger(__name__)

GRACE = 2  # seconds left to open connections when the server stops
BACKLOG = 2048
#: Seconds after which a thread that computes gives way to the loop that serves all: a tenth of what Python has set.
SWITCH_SECONDS = 0.0005
CONNECTIONS = 65_536  # open at once, where the machine lets it: each who waits for a verdict holds one or two


Prepare = Callable[[Settings, Course, Probing], None]
Announce = Callable[[FastAPI, str], None]


def run(arguments: Namespace) -> int:
    settings = read_settings(data_dir=arguments.data, trusted_proxy=arguments.trusted_proxy)

    def announce(app: FastAPI, address: str) -> None:
        _print_address(settings, get_service(app, Course), address)

    return serve(settings, arguments.host, arguments.port, announce)


def serve(settings: Settings, host: str, port: int, announce: Announce, prepare: Prepare | None = None) -> int:
    """The service, until it is told to stop. `prepare` comes before it, on a migrated database; `announce` once it
    answers, with its address."""
    logs.configure_logging("", settings.log_format)
    start_tracing_or_fail("web")
    _allow_many_connections()
    sys.setswitchinterval(SWITCH_SECONDS)
    with _open_listening_socket(host, port) as listener, lock_data_folder(settings):
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, _raise_system_exit)
        probing = start_probing_walls()
        with _freeze_and_disable_garbage_collection():
            _migrate_database(settings)
            course = load_course(render=False, check=True, memory=StartCache(settings.data_dir / CACHE_FILE))
        if probing.done():
            require_safe_sandbox(probing)
        if prepare is not None:
            prepare(settings, course, probing)
        walls = Gate()
        with _freeze_and_disable_garbage_collection():
            app = create_app(settings, course=course, walls=walls)

        def ready() -> None:
            announce(app, _format_address(listener))
            if settings.warm_up:
                Thread(target=_preload_in_background, args=(course,), name="read-ahead", daemon=True).start()
            if settings.warm_figures:
                get_service(app, FigureService).pictures.start_process_in_background()

        try:
            _serve_while_probing(app, settings, listener, ready, probing, walls)
        finally:
            traces.stop_tracing()
    return 0


def _allow_many_connections() -> None:
    """Most machines let a process open 1,024 files unless it asks for more, which a lecture hall goes beyond."""
    few, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = min(CONNECTIONS, most)
    if few < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))


def _preload_in_background(course: Course) -> None:
    preload_course(course)
    gc.freeze()


@contextmanager
def _freeze_and_disable_garbage_collection() -> Iterator[None]:
    """What is loaded stays: looking through it for what does not, again and again, would take a sixth of the time; and
    later, it would keep waiting whoever asks for something."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _raise_system_exit(_signal: int, _frame: FrameType | None) -> None:
    """Being asked to stop is no failure. (While it serves, uvicorn catches the signal, and raises it again after.)"""
    raise SystemExit(0)


class AnnouncingServer(uvicorn.Server):
    """uvicorn, which says when it is ready, as soon as it is told to stop, and when it begins to."""

    def __init__(
        self, config: uvicorn.Config, ready: Callable[[], None], told: Callable[[], None], stopping: Callable[[], None]
    ) -> None:
        super().__init__(config)
        self._ready, self._told, self._stopping = ready, told, stopping

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self._told()
        super().handle_exit(sig, frame)

    def request_stop(self) -> None:
        """From any thread."""
        self._told()
        self.should_exit = True

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        for listener in sockets or ():
            listener.listen(http_protocol.BACKLOG)
        if self.started:
            self._ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._stopping()
        await super().shutdown(sockets)


def build_uvicorn_config(app: FastAPI, settings: Settings) -> uvicorn.Config:
    """What a visitor's headers say of the address that they come from is believed from trusted proxies alone."""
    return http_protocol.uvicorn_config(app, grace=GRACE, proxies=list(settings.trusted_proxies))


def _serve_while_probing(
    app: FastAPI,
    settings: Settings,
    listener: socket.socket,
    ready: Callable[[], None],
    probing: Probing,
    walls: Gate,
) -> None:
    """Pages are served while the walls are tried; where they do not stand, it ends before any student's code ran."""
    end_streams = get_service(app, JobEvents).close  # open, they would keep it from ending
    server = AnnouncingServer(
        build_uvicorn_config(app, settings),
        ready,
        get_service(app, WorkerSupervisor).stop_restarting_workers,
        end_streams,
    )
    open_walls_once_probed(probing, walls, get_service(app, PrometheusMetrics), server.request_stop)
    server.run([listener])
    if not server.started:
        raise CommandError("le service n’a pas pu démarrer (voir les messages ci-dessus).")
    if probing.done():
        require_safe_sandbox(probing)


def open_walls_once_probed(probing: Probing, walls: Gate, metrics: PrometheusMetrics, stop: Callable[[], None]) -> None:
    """Lets students' code run once the walls are known to stand; has the service end where they do not."""

    def tried(done: Probing) -> None:
        if done.exception() is not None or not is_safe_to_serve(done.result()):
            stop()
            return
        metrics.set_wall_states({wall.name: wall.status is WallStatus.STANDING for wall in done.result()})
        walls.open()

    probing.add_done_callback(tried)


@contextmanager
def _open_listening_socket(host: str, port: int) -> Iterator[socket.socket]:
    """The listening socket; a port that is taken or an address that is not ours is told in words."""
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, kind, protocol, _, address = addresses[0]
        listener = socket.socket(family, kind, protocol)  # without its protocol, asyncio would leave Nagle's delays on
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(BACKLOG)
    except OSError as error:
        raise CommandError(_cannot_listen_message(error, host, port)) from error
    with listener:
        yield listener


def _cannot_listen_message(error: OSError, host: str, port: int) -> str:
    if error.errno == errno.EADDRINUSE:
        return f"le port {port} est déjà pris : choisissez-en un autre avec --port (0 : un port libre)."
    if error.errno == errno.EACCES:
        return f"le port {port} est réservé : choisissez-en un au-dessus de 1023 avec --port."
    return f"impossible d’écouter sur {host}:{port} : {error.strerror}."


def _migrate_database(settings: Settings) -> None:
    database = Database(settings.sqlalchemy_url)
    try:
        database.wait_until_available(STARTUP_TIMEOUT)
        back_up_before_upgrade(settings, database, TABLE_NAMES, utc_now())
        upgrade(database.engine)
    except (WrongSchemaError, BackupError) as error:
        raise CommandError(str(error)) from error
    except SQLAlchemyError as error:
        raise CommandError(database_problem(error)) from error
    finally:
        database.close()


def _format_address(listener: socket.socket) -> str:
    host, port = listener.getsockname()[:2]
    if host in {"0.0.0.0", "::"}:
        host = "localhost"
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def _print_address(settings: Settings, course: Course, address: str) -> None:
    for problem in course.problems:
        print(f"À corriger dans le cours — {problem}")
    address += settings.root_path
    print(f"\nBalise est prête : {address}/")
    print("  Étudiants : ouvrez cette adresse ; on y travaille comme invité, sans rien créer.")
    link = _administrator_link(settings)
    if link:
        print("  Enseignant : ce lien crée le compte de l’administrateur, qui enseigne aussi, et ne sert qu’une fois :")
        print(f"    {address}{link}")
    if not settings.workers:
        print("  Correction : aucun correcteur ici ; « balise worker », sur une autre machine, corrige ce qui attend.")
    if settings.on_postgres and not settings.nats_url:
        print("  Machines : celle-ci seule est prévenue de ce qui arrive ; pour plusieurs, réglez BALISE_NATS_URL.")
    print(f"  Données : {settings.data_dir}\n  Ctrl+C pour arrêter.\n", flush=True)


def _administrator_link(settings: Settings) -> str | None:
    database = Database(settings.sqlalchemy_url)
    try:
        with database.write() as db:
            token = links.create_administrator_invitation(db)
    except DBAPIError as error:
        if not is_unavailable(error):
            raise
        log.warning("the database does not answer: the next start tells the administrator's link, if there is one")
        return None
    finally:
        database.close()
    return None if token is None else f"/bienvenue/{token}"
