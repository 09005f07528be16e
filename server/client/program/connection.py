"""Requests to the server, by urllib."""

from __future__ import annotations

import json
import ssl
import time
import urllib.error
import urllib.request
from http.client import HTTPException
from typing import Any
from urllib.parse import quote, urlsplit
from uuid import uuid4

from .errors import ClientError, ServerUnavailableError

TIMEOUT_SECONDS = 60
WAIT_SECONDS = 20  # the server answers as soon as the verdict is there
PAUSES = (0.5, 1.0, 2.0, 4.0, 8.0)
MAX_WAIT_SECONDS = 900
MAX_BYTES = 8 << 20
SHORT_OF_ROOM, AWAY = 507, 503
NO_BALISE = "cette adresse ne répond pas comme un serveur Balise."
Json = Any


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    """A redirection would take the token to another address."""

    def redirect_request(self, *_arguments: Any, **_named: Any) -> None:
        return None


class ServerConnection:
    """One server, and the token of one account."""

    def __init__(self, server: str, token: str) -> None:
        parts = urlsplit(server)
        if parts.scheme not in ("http", "https") or not parts.netloc:
            raise ClientError(f"l’adresse du serveur doit commencer par http:// ou https:// : « {server} ».")
        if not token.isascii() or not token.isprintable():
            raise ClientError("le jeton porte un caractère qui n’en fait pas partie ; recopiez-le depuis votre compte.")
        self.server, self._token = server.rstrip("/"), token
        self._opener = urllib.request.build_opener(_NoRedirect)

    def get_json(self, path: str) -> Json:
        return _parse_json(self._request("GET", path))

    def get_bytes(self, path: str) -> bytes:
        return self._request("GET", path)

    def list_exercises(self) -> list[dict[str, Json]]:
        """Return the exercises, in the order of the course."""
        found = self.get_json("/api/v1/exercises")
        if not isinstance(found, list):
            raise ClientError(NO_BALISE)
        return found

    def load_exercise(self, name: str) -> dict[str, Json]:
        return dict(self.get_json(f"/api/v1/exercises/{quote(name)}"))

    def load_last_submitted_file(self, name: str) -> dict[str, Json]:
        """Return the last file that this account has sent: `code`, `created_at`, `submission`."""
        return dict(self.get_json(f"/api/v1/me/exercises/{quote(name)}/last"))

    def submit(self, exercise: str, content: dict[str, Json]) -> dict[str, Json]:
        """Send a file or answers once, whatever is cut off, and return the submission as it is stored.

        Sent again under the same key, it is stored once.
        """
        body = json.dumps({"exercise": exercise, **content}).encode()
        headers = {"Content-Type": "application/json", "Idempotency-Key": uuid4().hex}
        path = f"/api/v1/submissions?reuse=true&wait={WAIT_SECONDS}"
        for pause in PAUSES:
            try:
                return dict(_parse_json(self._request("POST", path, body, headers)))
            except ServerUnavailableError:
                time.sleep(pause)
        return dict(_parse_json(self._request("POST", path, body, headers)))

    def wait_until_graded_or_held(self, submission: dict[str, Json]) -> dict[str, Json]:
        """Wait for the verdict, or until a test holds it back; return the submission."""
        path = f"/api/v1/submissions/{submission['id']}"
        deadline = time.monotonic() + MAX_WAIT_SECONDS
        pauses = iter(PAUSES)
        while submission.get("status") != "done" and not submission.get("held"):
            if time.monotonic() > deadline:
                raise ClientError(
                    f"le verdict se fait attendre ; il sera à l’adresse {self.attempt_page_url(submission)}"
                )
            time.sleep(next(pauses, PAUSES[-1]))
            try:
                submission = dict(self.get_json(path))
            except ServerUnavailableError:
                continue
        return submission

    def attempt_page_url(self, submission: dict[str, Json]) -> str:
        return f"{self.server}/soumissions/{submission['id']}"

    def _request(
        self, method: str, path: str, body: bytes | None = None, headers: dict[str, str] | None = None
    ) -> bytes:
        request = urllib.request.Request(self.server + path, body, method=method)
        sent = {"Authorization": f"Bearer {self._token}", "Accept": "application/json", **(headers or {})}
        for name, value in sent.items():
            request.add_header(name, value)
        try:
            with self._opener.open(request, timeout=TIMEOUT_SECONDS) as answer:
                content: bytes = answer.read(MAX_BYTES)
                return content
        except urllib.error.HTTPError as error:
            raise _refusal_error(error) from error
        except (OSError, HTTPException) as error:
            raise self._unreachable_error(error) from error

    def _unreachable_error(self, error: Exception) -> ClientError:
        reason = getattr(error, "reason", error)
        if isinstance(reason, ssl.SSLError):
            return ClientError(f"la connexion chiffrée à {self.server} est refusée (certificat) : {reason}.")
        if isinstance(reason, TimeoutError):
            return ServerUnavailableError(f"{self.server} met trop de temps à répondre.")
        return ServerUnavailableError(
            f"impossible de joindre {self.server} : le serveur ne répond pas à cette adresse."
        )


def _refusal_error(error: urllib.error.HTTPError) -> ClientError:
    try:
        problem = json.loads(error.read(MAX_BYTES))
        detail = str(problem["detail"])
        places = [f"\n  {place.get('pointer', '')} : {place['detail']}" for place in problem.get("errors") or ()]
    except (ValueError, KeyError, TypeError, AttributeError, OSError):
        return ClientError(f"le serveur répond {error.code}, sans explication.")
    message = f"le serveur refuse ({error.code}) : {detail}{''.join(places)}"
    return ServerUnavailableError(message) if error.code in (AWAY, SHORT_OF_ROOM) else ClientError(message)


def _parse_json(content: bytes) -> Json:
    try:
        return json.loads(content)
    except ValueError as error:
        raise ClientError(NO_BALISE) from error
