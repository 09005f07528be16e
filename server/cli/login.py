"""`balise login --server URL`: keeps a token for `balise submit`, once the server has recognised it."""

import sys
from argparse import Namespace
from getpass import getpass

import httpx

from server.cli import CommandError, stored_tokens
from server.cli.remote import (
    NO_BALISE,
    explain_error,
    make_client,
    raise_for_error_status,
    resolve_server,
    resolve_token,
)


def run(arguments: Namespace) -> int:
    server = resolve_server(arguments.server)
    token = resolve_token(_read_typed_token(server), server)
    try:
        with make_client(server, token) as client:
            answer = client.get("/api/v1/exercises")
    except (httpx.HTTPError, httpx.InvalidURL) as error:
        raise CommandError(explain_error(error, server)) from error
    raise_for_error_status(answer)
    if not answer.headers.get("content-type", "").startswith("application/json"):
        raise CommandError(NO_BALISE)
    stored_tokens.save_token(server, token)
    print(f"Jeton gardé dans {stored_tokens.path()}, que vous seul pouvez lire.")
    print(f"« balise submit EXERCICE FICHIER » envoie désormais à {server}.")
    return 0


def _read_typed_token(server: str) -> str:
    """Read without showing it; from the standard input where that is no keyboard. Raises CommandError."""
    if sys.stdin.isatty():
        token = getpass(f"Jeton créé sur {server}/compte (rien ne s’affiche) : ")
    else:
        token = sys.stdin.readline()
    if not token.strip():
        raise CommandError("aucun jeton n’a été donné.")
    return token.strip()
