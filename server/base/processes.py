"""Processes of ours: what they are given, and that they end with the one that started them."""

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
#: What says nothing secret, and every process needs.
COMMON = ("BALISE_LOG_FORMAT", "BALISE_COURSES")


def die_with_parent(parent: int) -> None:
    """Has the kernel end this process when its parent does; ends it now if that has already happened."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl(PR_SET_PDEATHSIG)")
    if os.getppid() != parent:
        sys.exit(0)


def child_environment(settings: Settings) -> dict[str, str]:
    """This process's environment, with every setting, and the project importable from any folder."""
    values = {name: value for name, value in settings.model_dump(mode="json").items() if value is not None}
    settings_env = {f"BALISE_{name.upper()}": str(value) for name, value in values.items()}
    return {**os.environ, **settings_env, "PYTHONPATH": _path()}


def bare_environment() -> dict[str, str]:
    """The same without any setting but the form of logs and the courses: the database's password is among them."""
    others = {name: value for name, value in os.environ.items() if name in COMMON or not name.startswith("BALISE_")}
    return {**others, "PYTHONPATH": _path()}


def _path() -> str:
    return os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
