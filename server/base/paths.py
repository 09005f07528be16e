"""Where the project's own files and the user's data live."""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TEMPLATES = ROOT / "templates"


def default_cache_dir() -> Path:
    """What may be lost at any time: `$XDG_CACHE_HOME/balise` where that is absolute, or `~/.cache/balise`."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(base) if Path(base).is_absolute() else Path.home() / ".cache") / "balise"


def default_data_dir() -> Path:
    """The data folder of this user: `$XDG_DATA_HOME/balise`, or `~/.local/share/balise`."""
    base = os.environ.get("XDG_DATA_HOME")
    return (Path(base) if base else Path.home() / ".local" / "share") / "balise"
