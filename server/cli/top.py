"""`balise top [--server URL | --data DIR] [--once] [--json]`: what the service does now, shown again and again."""

from __future__ import annotations

import json
import shutil
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any

from server.cli import CommandError

REFRESH_SECONDS = 2.0  # seconds
MIN_WIDTH, MAX_WIDTH = 60, 120
HOME_AND_CLEAR, BOLD, RED, PLAIN = "\033[H\033[2J", "\033[1m", "\033[31m", "\033[0m"
KINDS = {
    "grade": "corrections",
    "regrade": "recorrections",
    "fingerprint": "regroupements d’erreurs",
    "trial": "vérifications d’exercices d’enseignants",
    "tryout": "essais de brouillons d’exercices",
}
CHECKS = {
    **{"database": "base", "walls": "protections", "workers": "correcteurs", "service": "service"},
    **{"nats": "NATS", "disk": "disque"},
}
CHECK_STATES = {
    "unreachable": "injoignable",
    "being tried": "à l’essai",
    "none": "aucun",
    "stopping": "s’arrête",
    "nearly full": "presque plein",
    "unknown": "inconnu",
}
Json = Mapping[str, Any]
Read = Callable[[], Json]


def run(arguments: Namespace) -> int:
    if arguments.server is not None:
        return _refresh_until_stopped(arguments, _build_remote_reader(arguments))
    from server.cli.configuration import read_settings
    from server.cli.database import open_database

    with open_database(read_settings(data_dir=arguments.data)) as database:
        return _refresh_until_stopped(arguments, _build_local_reader(database))


def _build_remote_reader(arguments: Namespace) -> Read:
    import httpx

    from server.cli.remote import explain_error, make_client, request_json, resolve_server, resolve_token

    server = resolve_server(arguments.server)
    client = make_client(server, resolve_token(arguments.token, server))

    def read() -> Json:
        try:
            return request_json(client, "GET", "/statusz", headers={"Accept": "application/json"})
        except (httpx.HTTPError, httpx.InvalidURL) as error:
            raise CommandError(explain_error(error, server)) from error

    return read


def _build_local_reader(database: Any) -> Read:
    """Read the database alone: visitors, walls and logged errors are known to the service only."""
    from server.cli.database import explaining_database_errors
    from server.health import service_status

    def read() -> Json:
        with explaining_database_errors(), database.read() as db:
            return service_status.service_status_to_json(service_status.load_service_status(db))

    return read


def _refresh_until_stopped(arguments: Namespace, read: Read) -> int:
    if arguments.json:
        print(json.dumps(read(), ensure_ascii=False))
        return 0
    terminal = sys.stdout.isatty()
    if arguments.once or not terminal:
        print(render_top(read(), _terminal_width(), colours=terminal))
        return 0
    while True:
        screen = render_top(_read_with_retries(read), _terminal_width(), colours=True)
        print(f"{HOME_AND_CLEAR}{screen}\n\n  Ctrl+C pour finir.", flush=True)
        time.sleep(REFRESH_SECONDS)


def _read_with_retries(read: Read) -> Json:
    """A service that starts again is waited for: one refusal is no end."""
    try:
        return read()
    except CommandError:
        time.sleep(REFRESH_SECONDS)
        return read()


def _terminal_width() -> int:
    return max(MIN_WIDTH, min(MAX_WIDTH, shutil.get_terminal_size((80, 24)).columns))


def render_top(state: Json, width: int, *, colours: bool) -> str:
    """The screen: no line is wider than `width`, and nothing but text stands in it without `colours`."""
    lines = [
        *_head_lines(state),
        *_queue_lines(state["queue"]),
        *_worker_lines(state["workers"]),
        *_fault_lines(state["faults"]),
    ]
    return "\n".join(_colour_line(_truncate(line, width), colours) for line in lines)


def _truncate(line: str, width: int) -> str:
    """Truncate a line, and replace control characters: a log may hold terminal commands."""
    plain = "".join(character if character.isprintable() else "\ufffd" for character in line)
    return plain if len(plain) <= width else plain[: width - 1] + "…"


def _colour_line(line: str, colours: bool) -> str:
    if not colours:
        return line
    if line.startswith("!"):
        return f"{RED}{line}{PLAIN}"
    return f"{BOLD}{line}{PLAIN}" if line and not line.startswith(" ") else line


def _head_lines(state: Json) -> Iterator[str]:
    process, verdicts = state.get("process"), state["verdicts"]
    yield f"Balise, {_format_local_time(state['at'])}"
    if process is None:
        yield "  Lu dans la base : visiteurs, protections et journaux se lisent avec --server."
    else:
        yield (
            f"  Visiteurs (5 min) : {process['visitors']} · demandes/min : {process['requests_per_minute']:.0f} · "
            f"pages en direct : {process['following']}"
        )
        yield from _problem_lines(process)
    times = "aucun depuis 15 min" if verdicts["p50"] is None else (
        f"p50 {_format_seconds(verdicts['p50'])} · p95 {_format_seconds(verdicts['p95'])} (15 min)"
    )  # fmt: skip
    yield f"  Verdicts : {_format_number(verdicts['per_minute'])}/min · {times}"


def _problem_lines(process: Json) -> Iterator[str]:
    walls = process["walls"]
    fallen = [name for name, stands in walls.items() if not stands]
    standing = f"{len(walls) - len(fallen)}/{len(walls)}" if walls else "à l’essai"
    yield f"  Protections : {standing} · correcteurs d’ici : {process['workers']}/{process['wanted']}"
    if fallen:
        yield f"! Protections absentes : {', '.join(fallen)}"
    for name, state_text in process["checks"].items():
        if state_text != "ok":
            yield f"! {CHECKS.get(name, name)} : {CHECK_STATES.get(state_text, state_text)}"


def _queue_lines(queue: Sequence[Json]) -> Iterator[str]:
    yield ""
    yield f"{'File':<28}{'attendent':>10}{'le plus ancien':>16}{'en cours':>10}"
    if not queue:
        yield "  rien n’attend"
    for depth in queue:
        oldest = _format_seconds(depth["oldest"]) if depth["waiting"] else "—"
        name = KINDS.get(depth["kind"], depth["kind"])
        yield f"  {name:<26}{depth['waiting']:>10}{oldest:>16}{depth['running']:>10}"


def _worker_lines(workers: Sequence[Json]) -> Iterator[str]:
    yield ""
    yield f"{'Correcteurs au travail':<28}{'depuis':>10}  {'sur':<24}{'essai':>6}"
    if not workers:
        yield "  aucun"
    for worker in workers:
        who = f"{worker['host'][:18]}[{worker['pid']}]"
        what = worker["exercise"] or KINDS.get(worker["kind"], worker["kind"])
        yield f"  {who:<26}{_format_seconds(worker['seconds']):>10}  {what:<24}{worker['tries']:>6}"


def _fault_lines(faults: Sequence[Json]) -> Iterator[str]:
    yield ""
    yield "Dernières erreurs"
    if not faults:
        yield "  aucune"
    for error in faults:
        yield f"! {_format_local_time(error['at'])} {error['where']} : {error['message']}"


def _format_local_time(text: str) -> str:
    return datetime.fromisoformat(text).astimezone().strftime("%H:%M:%S")


def _format_seconds(value: float) -> str:
    if value < 1:
        return f"{value * 1000:.0f} ms"
    if value < 60:
        return f"{_format_number(value)} s"
    minutes, seconds = divmod(round(value), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02}" if hours else f"{minutes} min {seconds:02}"


def _format_number(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0").replace(".", ",")
