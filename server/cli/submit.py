"""`balise submit EXERCISE FILE --server URL --token T`: sends a file, or the answers in a .json, and follows it."""

import json
import ssl
import sys
from argparse import Namespace
from collections.abc import Iterator
from typing import Any

import httpx

from graders.core.contract.verdict import MalformedVerdictError, Verdict
from server.cli import CannotRun, report
from server.cli.files import ANSWERS, read_answers, read_text

Json = dict[str, Any]
JSON = {"Content-Type": "application/json"}
TIMEOUT = httpx.Timeout(10, read=60)
RECONNECTIONS = 5
NO_BALISE = "cette adresse ne répond pas comme un serveur Balise."


def run(arguments: Namespace) -> int:
    answers = arguments.file.endswith(ANSWERS)
    body = {"answers": read_answers(arguments.file)} if answers else {"code": read_text(arguments.file)}
    if not arguments.token.isascii():
        raise CannotRun("le jeton porte un caractère qui n’en fait pas partie ; recopiez-le depuis votre compte.")
    headers = {"Authorization": f"Bearer {arguments.token}"}
    try:
        with httpx.Client(base_url=_base(arguments.server), headers=headers, timeout=TIMEOUT) as client:
            verdict = _verdict(client, {"exercise": arguments.exercise, **body})
    except (httpx.HTTPError, httpx.InvalidURL) as error:
        raise CannotRun(_explained(error, arguments.server)) from error
    print(report.render(verdict))
    return report.exit_status(verdict)


def _base(server: str) -> str:
    if not server.startswith(("http://", "https://")):
        raise CannotRun(f"l’adresse du serveur doit commencer par http:// ou https:// : « {server} ».")
    return server.rstrip("/")


def _verdict(client: httpx.Client, submission: Json) -> Verdict:
    url = _ask(client, "POST", "/api/v1/submissions", content=json.dumps(submission), headers=JSON).get("url")
    if not isinstance(url, str):
        raise CannotRun(NO_BALISE)
    for _ in range(RECONNECTIONS):
        for current in _events(client, url):
            if current.get("status") == "done":
                return _read(current.get("verdict"))
            _tell(current)
    raise CannotRun(f"le serveur n’a pas donné de verdict ; il se trouvera à l’adresse {url}.")


def _read(verdict: Any) -> Verdict:
    try:
        return Verdict.from_json(verdict)
    except MalformedVerdictError as error:
        place = f" (à « {error.place} »)" if error.place else ""
        raise CannotRun(f"ce que le serveur répond n’est pas un verdict que ce programme sait lire{place}.") from error


def _ask(client: httpx.Client, method: str, url: str, **options: Any) -> Json:
    answer = client.request(method, url, **options)
    _check(answer)
    return _json_object(answer.text)


def _json_object(text: str) -> Json:
    try:
        content = json.loads(text)
    except ValueError as error:
        raise CannotRun(NO_BALISE) from error
    if not isinstance(content, dict):
        raise CannotRun(NO_BALISE)
    return content


def _check(answer: httpx.Response) -> None:
    if answer.is_success:
        return
    if answer.headers.get("content-type") != "application/problem+json":
        raise CannotRun(f"le serveur répond {answer.status_code}, sans explication.")
    problem = _json_object(answer.text)
    places = "".join(f"\n  {error.get('pointer', '')} : {error['detail']}" for error in problem.get("errors") or ())
    raise CannotRun(f"le serveur refuse ({answer.status_code}) : {problem['detail']}{places}")


def _events(client: httpx.Client, url: str) -> Iterator[Json]:
    """The data of each server-sent event."""
    with client.stream("GET", f"{url}/events") as answer:
        if not answer.is_success:
            answer.read()
        _check(answer)
        for line in answer.iter_lines():
            if line.startswith("data:"):
                yield _json_object(line.removeprefix("data:"))


def _tell(current: Json) -> None:
    place = f"en attente, place {current['position']}" if current.get("position") else "correction en cours"
    print(current.get("notice") or f"{place}…", file=sys.stderr)


def _explained(error: Exception, server: str) -> str:
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, ssl.SSLError):
            return f"la connexion chiffrée à {server} est refusée (certificat) : {cause}."
        cause = cause.__cause__ or cause.__context__
    if isinstance(error, httpx.ConnectError):
        return f"impossible de joindre {server} : le serveur ne répond pas à cette adresse."
    if isinstance(error, httpx.TimeoutException):
        return f"{server} met trop de temps à répondre."
    return f"l’échange avec {server} a échoué : {error}."
