"""`balise login --server URL`: keeps a token for `balise submit`, once the server has recognised it."""

import sys
from argparse import Namespace
from getpass import getpass

import httpx

from server.cli import CannotRun, stored_tokens
from server.cli.remote import NO_BALISE, check, client_of, explained, server_of, token_of


def run(arguments: Namespace) -> int:
    server = server_of(arguments.server)
    token = token_of(_typed(server), server)
    try:
        with client_of(server, token) as client:
            answer = client.get("/api/v1/exercises")
    except (httpx.HTTPError, httpx.InvalidURL) as error:
        raise CannotRun(explained(error, server)) from error
    check(answer)
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
