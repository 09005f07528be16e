"""API tokens by server, in the file that the whole package uses too (`balise login`)."""

from __future__ import annotations

import json
import os
from pathlib import Path

from .errors import ClientError

VARIABLE = "BALISE_TOKEN"


def token_file_path() -> Path:
    """Return the path of the file, following the XDG base directories."""
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    return (Path(folder) if Path(folder).is_absolute() else Path.home() / ".config") / "balise" / "tokens.json"


def load_tokens_by_server() -> dict[str, str]:
    """Load the tokens by server; the latest stored comes last."""
    try:
        content = json.loads(token_file_path().read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise ClientError(f"les jetons gardés dans {token_file_path()} ne se lisent pas : {error}.") from error
    if not isinstance(content, dict) or not all(isinstance(token, str) for token in content.values()):
        raise ClientError(f"{token_file_path()} n’est pas un fichier de jetons : refaites la commande « login ».")
    return content


def save_token(server: str, token: str) -> None:
    """Store a token in a file that its owner alone may read, replaced atomically."""
    others = {name: value for name, value in load_tokens_by_server().items() if name != server}
    file = token_file_path()
    try:
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        unfinished = file.with_name(f"{file.name}.{os.getpid()}")
        handle = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with open(handle, "w", encoding="utf-8") as written:
            written.write(json.dumps({**others, server: token}, indent=2))
        unfinished.replace(file)
    except OSError as error:
        raise ClientError(f"le jeton ne peut pas être gardé dans {file} : {error.strerror}.") from error


def find_token(server: str, option_token: str | None = None) -> str:
    """Return the option's token, the environment's, or the stored one. Raises ClientError where there is none."""
    token = option_token or os.environ.get(VARIABLE, "").strip() or load_tokens_by_server().get(server)
    if not token:
        raise ClientError(
            f"il manque un jeton : créez-en un sur {server}/compte, puis « login » (ou la variable {VARIABLE})."
        )
    return token
