"""HTTP client of the commands that talk to a server."""

import json
import os
import ssl
from typing import Any

import httpx

from server.cli import CommandError, stored_tokens

Json = dict[str, Any]
TIMEOUT = httpx.Timeout(10, read=60)
NO_BALISE = "cette adresse ne répond pas comme un serveur Balise."
NO_SERVER = "à quel serveur ? Donnez --server URL, ou commencez par « balise login --server URL »."
NO_TOKEN = (
    "il manque un jeton : créez-en un sur la page « Mon compte » du serveur, puis « balise login --server {server} » "
    "(ou --token, ou la variable BALISE_TOKEN)."
)


def resolve_server(option: str | None) -> str:
    """Return the server's address: the option's, or that of the last `balise login`."""
    if option is None:
        servers = list(stored_tokens.load_tokens_by_server())
        if not servers:
            raise CommandError(NO_SERVER)
        return servers[-1]
    if not option.startswith(("http://", "https://")):
        raise CommandError(f"l’adresse du serveur doit commencer par http:// ou https:// : « {option} ».")
    return option.rstrip("/")


def resolve_token(option: str | None, server: str) -> str:
    """Return the option's token, the environment's, or the one stored for this server."""
    token = option or os.environ.get("BALISE_TOKEN", "").strip() or stored_tokens.load_tokens_by_server().get(server)
    if not token:
        raise CommandError(NO_TOKEN.format(server=server))
    if not token.isascii() or not token.isprintable():
        raise CommandError("le jeton porte un caractère qui n’en fait pas partie ; recopiez-le depuis votre compte.")
    return token


def make_client(server: str, token: str) -> httpx.Client:
    return httpx.Client(base_url=server, headers={"Authorization": f"Bearer {token}"}, timeout=TIMEOUT)


def request_json(client: httpx.Client, method: str, url: str, **options: Any) -> Json:
    answer = client.request(method, url, **options)
    raise_for_error_status(answer)
    return parse_json_object(answer.text)


def parse_json_object(text: str) -> Json:
    try:
        content = json.loads(text)
    except ValueError as error:
        raise CommandError(NO_BALISE) from error
    if not isinstance(content, dict):
        raise CommandError(NO_BALISE)
    return content


def raise_for_error_status(response: httpx.Response) -> None:
    if response.is_success:
        return
    if response.headers.get("content-type") != "application/problem+json":
        raise CommandError(f"le serveur répond {response.status_code}, sans explication.")
    problem = parse_json_object(response.text)
    locations = "".join(f"\n  {error.get('pointer', '')} : {error['detail']}" for error in problem.get("errors") or ())
    raise CommandError(f"le serveur refuse ({response.status_code}) : {problem['detail']}{locations}")


def explain_error(error: Exception, server: str) -> str:
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
