"""Child processes: their environment, and their death with their parent."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from typing import TYPE_CHECKING

from server.base.files import ROOT

if TYPE_CHECKING:
    from server.base.settings import Settings  # with pydantic, which who draws has no use for

_PR_SET_PDEATHSIG = 1
#: Settings without secrets that every process needs.
COMMON_VARIABLES = ("BALISE_LOG_FORMAT", "BALISE_COURSES")


def die_with_parent(parent: int) -> None:
    """Have the kernel kill this process when its parent dies; exit now if it is dead already."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl(PR_SET_PDEATHSIG)")
    if os.getppid() != parent:
        sys.exit(0)


def child_environment(settings: Settings) -> dict[str, str]:
    """Return this process's environment, with every setting, and the project importable from any folder."""
    values = {name: value for name, value in settings.model_dump(mode="json").items() if value is not None}
    settings_env = {f"BALISE_{name.upper()}": str(value) for name, value in values.items()}
    return {**os.environ, **settings_env, "PYTHONPATH": _python_path()}


def bare_environment() -> dict[str, str]:
    """Return the environment without settings, except `COMMON_VARIABLES`: no password of a database."""
    variables = {
        name: value for name, value in os.environ.items() if name in COMMON_VARIABLES or not name.startswith("BALISE_")
    }
    return {**variables, "PYTHONPATH": _python_path()}


def _python_path() -> str:
    return os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
