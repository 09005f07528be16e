"""API tokens stored by `balise login`, in a file of the user's configuration folder that only its owner may read."""

import json
import os
from pathlib import Path

from server.base.files import OWNER_ONLY, write_atomically
from server.cli import CannotRun

NAME = Path("balise", "tokens.json")


def path() -> Path:
    """Return the path of the file, following the XDG base directories."""
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    return (Path(folder) if Path(folder).is_absolute() else Path.home() / ".config") / NAME


def read() -> dict[str, str]:
    """Load the tokens by server; the latest stored comes last."""
    try:
        content = json.loads(path().read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise CannotRun(f"les jetons gardés dans {path()} ne se lisent pas : {error}.") from error
    if not isinstance(content, dict) or not all(isinstance(token, str) for token in content.values()):
        raise CannotRun(f"{path()} n’est pas un fichier de jetons : refaites « balise login ».")
    return content


def save(server: str, token: str) -> None:
    """Store a token; the file is replaced atomically and never readable by others."""
    others = {name: value for name, value in read().items() if name != server}
    try:
        path().parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_atomically(path(), json.dumps({**others, server: token}, indent=2), OWNER_ONLY)
    except OSError as error:
        raise CannotRun(f"le jeton ne peut pas être gardé dans {path()} : {error.strerror}.") from error
