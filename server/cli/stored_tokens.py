"""API tokens stored by `balise login`, in the file that `balise.pyz` uses too."""

from collections.abc import Iterator
from contextlib import contextmanager

from server.cli import CannotRun
from server.client.program import tokens
from server.client.program.errors import ClientError

path = tokens.token_file_path


def read() -> dict[str, str]:
    """Load the tokens by server; the latest stored comes last."""
    with _explained():
        return tokens.load_tokens_by_server()


def save(server: str, token: str) -> None:
    """Store a token; the file is replaced atomically and never readable by others."""
    with _explained():
        tokens.save_token(server, token)


@contextmanager
def _explained() -> Iterator[None]:
    try:
        yield
    except ClientError as error:
        raise CannotRun(str(error)) from error
