"""API tokens stored by `balise login`, in the file that `balise.pyz` uses too."""

from collections.abc import Iterator
from contextlib import contextmanager

from server.cli import CommandError
from server.client.program import tokens
from server.client.program.errors import ClientError

path = tokens.token_file_path


def load_tokens_by_server() -> dict[str, str]:
    """Load the tokens by server; the latest stored comes last."""
    with _explain_file_errors():
        return tokens.load_tokens_by_server()


def save_token(server: str, token: str) -> None:
    """Store a token; the file is replaced atomically and never readable by others."""
    with _explain_file_errors():
        tokens.save_token(server, token)


@contextmanager
def _explain_file_errors() -> Iterator[None]:
    try:
        yield
    except ClientError as error:
        raise CommandError(str(error)) from error
