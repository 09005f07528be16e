"""`balise worker`: grades for a server, from another machine; both share one database."""

import logging
import os
import sys
from argparse import Namespace

from sqlalchemy import make_url

from server.base import logs, traces
from server.cli import CommandError
from server.cli.configuration import read_settings, start_tracing_or_fail
from server.cli.database import open_database
from server.cli.sandboxes import require_safe_sandbox, start_probing_walls
from server.database import STARTUP_TIMEOUT
from server.grading.worker_process import run_worker, stop_on_signals
from server.health.event_counter import TemplateRenewalCounter
from server.queue.graceful_stop import StopRequested
from server.queue.interfaces import NullNotifier
from server.queue.polling import PollingSource

ALONE = (
    "Une base de données ne prévient personne : le travail y est cherché dix fois par seconde. Sur plusieurs machines, "
    "réglez BALISE_NATS_URL (et PostgreSQL), ici et sur chaque serveur."
)


def run(_arguments: Namespace) -> int:
    settings = read_settings()
    if settings.database_url is None:
        raise CommandError("indiquez la base de données du serveur dans BALISE_DATABASE_URL.")
    require_safe_sandbox(start_probing_walls())
    logs.configure_logging(f"worker[{os.getpid()}]", settings.log_format, logging.INFO)
    start_tracing_or_fail(f"worker[{os.getpid()}]")
    stop_on_signals(interrupt=True)
    try:
        with open_database(settings, patience=STARTUP_TIMEOUT, await_schema=True) as database:
            if not settings.nats_url:
                print(ALONE, file=sys.stderr)
            place = make_url(settings.sqlalchemy_url).render_as_string(hide_password=True)
            print(f"Balise corrige ce qui attend dans {place} ; Ctrl+C pour arrêter.", flush=True)
            run_worker(
                settings, PollingSource(), NullNotifier(), TemplateRenewalCounter(database).count_template_renewal
            )
    except StopRequested:
        return 0
    finally:
        traces.stop_tracing()
    return 0
