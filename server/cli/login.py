"""`balise login --server URL`: keeps a token for `balise submit`, once the server has recognised it."""

import sys
from argparse import Namespace
from getpass import getpass

import httpx

from server.cli import CannotRun, stored_tokens
from server.cli.remote import NO_BALISE, explain_error, make_client, require_success, resolve_server, resolve_token


def run(arguments: Namespace) -> int:
    server = resolve_server(arguments.server)
    token = resolve_token(_typed(server), server)
    try:
        with make_client(server, token) as client:
            answer = client.get("/api/v1/exercises")
    except (httpx.HTTPError, httpx.InvalidURL) as error:
        raise CannotRun(explain_error(error, server)) from error
    require_success(answer)
    if not answer.headers.get("content-type", "").startswith("application/json"):
        raise CannotRun(NO_BALISE)
    stored_tokens.save(server, token)
    print(f"Jeton gardé dans {stored_tokens.path()}, que vous seul pouvez lire.")
    print(f"« balise submit EXERCICE FICHIER » envoie désormais à {server}.")
    return 0


def _typed(server: str) -> str:
    """Read without showing it; from the standard input where that is no keyboard. Raises CannotRun."""
    if sys.stdin.isatty():
        token = getpass(f"Jeton créé sur {server}/compte (rien ne s’affiche) : ")
    else:
        token = sys.stdin.readline()
    if not token.strip():
        raise CannotRun("aucun jeton n’a été donné.")
    return token.strip()
