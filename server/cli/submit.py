"""`balise submit EXERCISE FILE [--server URL] [--token T]`: sends a file, or the answers in a .json, and follows it."""

import json
import sys
import time
from argparse import Namespace
from collections.abc import Iterator
from contextlib import suppress
from typing import Any
from uuid import uuid4

import httpx

from graders.core.contract.verdict import MalformedVerdictError, Verdict
from server.cli import CommandError, report
from server.cli.files import ANSWERS, read_answers, read_text
from server.cli.remote import (
    NO_BALISE,
    Json,
    explain_error,
    make_client,
    parse_json_object,
    raise_for_error_status,
    request_json,
    resolve_server,
    resolve_token,
)

SUBMISSIONS = "/api/v1/submissions"
JSON = {"Content-Type": "application/json"}
#: Seconds between two tries, where the exchange was cut off or the service is away.
PAUSES = (0.5, 1.0, 2.0, 4.0, 8.0)
AWAY = 503


def run(arguments: Namespace) -> int:
    answers = arguments.file.endswith(ANSWERS)
    body = {"answers": read_answers(arguments.file)} if answers else {"code": read_text(arguments.file)}
    server = resolve_server(arguments.server)
    try:
        with make_client(server, resolve_token(arguments.token, server)) as client:
            verdict = _wait_for_verdict(client, {"exercise": arguments.exercise, **body})
    except (httpx.HTTPError, httpx.InvalidURL) as error:
        raise CommandError(explain_error(error, server)) from error
    if isinstance(verdict, str):
        print(verdict or "Reçu ; résultat après la publication par l’enseignant.")
        return report.NOT_FULL if verdict else report.FULL_MARKS
    print(report.render_verdict(verdict))
    return report.exit_status_of_verdict(verdict)


def _wait_for_verdict(client: httpx.Client, submission: Json) -> Verdict | str:
    """Return the verdict; where a test holds it back, why the file does not run, or an empty text."""
    stored = _send_once(client, submission)
    if stored.get("status") == "done":
        print("déjà envoyé : voici son verdict.", file=sys.stderr)
    url = stored.get("url")
    if not isinstance(url, str):
        raise CommandError(NO_BALISE)
    url = url.removeprefix(client.base_url.path.rstrip("/"))  # which the client puts before it
    for pause in (0.0, *PAUSES):
        time.sleep(pause)
        with suppress(httpx.TransportError, _ServiceUnavailableError):
            held = bool(stored.get("held"))
            for current in _iterate_server_sent_events(client, url):
                held = bool(current.get("held"))
                if held and current.get("load_error"):
                    return str(current.get("notice"))
                if current.get("status") == "done":
                    return _parse_verdict(current.get("verdict"))
                if not held:
                    _print_status(current)
            if held:
                return ""
    raise CommandError(f"le serveur n’a pas donné de verdict ; il se trouvera à l’adresse {url}.")


class _ServiceUnavailableError(Exception):
    """The service says so itself, and to come back."""


def _send_once(client: httpx.Client, submission: Json) -> Json:
    """Store the submission once: it is sent again under the same idempotency key where no answer came."""
    headers = {**JSON, "Idempotency-Key": uuid4().hex}
    options: dict[str, Any] = {"params": {"reuse": True}, "content": json.dumps(submission), "headers": headers}
    for pause in PAUSES:
        try:
            answer = client.request("POST", SUBMISSIONS, **options)
        except httpx.ConnectError:
            raise
        except httpx.TransportError:
            answer = None
        if answer is not None and answer.status_code != AWAY:
            raise_for_error_status(answer)
            return parse_json_object(answer.text)
        print("l’échange a été coupé, nouvel essai…", file=sys.stderr)
        time.sleep(pause)
    return request_json(client, "POST", SUBMISSIONS, **options)


def _parse_verdict(verdict: Any) -> Verdict:
    try:
        return Verdict.from_json(verdict)
    except MalformedVerdictError as error:
        place = f" (à « {error.place} »)" if error.place else ""
        raise CommandError(
            f"ce que le serveur répond n’est pas un verdict que ce programme sait lire{place}."
        ) from error


def _iterate_server_sent_events(client: httpx.Client, url: str) -> Iterator[Json]:
    """The data of each server-sent event."""
    with client.stream("GET", f"{url}/events") as answer:
        if answer.status_code == AWAY:
            raise _ServiceUnavailableError
        if not answer.is_success:
            answer.read()
        raise_for_error_status(answer)
        for line in answer.iter_lines():
            if line.startswith("data:"):
                yield parse_json_object(line.removeprefix("data:"))


def _print_status(current: Json) -> None:
    place = f"en attente, place {current['position']}" if current.get("position") else "correction en cours"
    print(current.get("notice") or f"{place}…", file=sys.stderr)
