"""An ordinary user beside root: who it is, and whether this machine lets it run the sandbox."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
SYSTEM_PYTHON = "/usr/bin/python3"
#: What begins a command that root has an ordinary user run.
ORDINARY = ["runuser", "-u", "nobody", "--"]


def python_of_nobody() -> tuple[str, str]:
    """A Python that an ordinary user can run the sandbox with, else "" and the reason; for root to ask."""
    if os.geteuid() != 0 or not shutil.which("runuser"):
        return "", "only root can become another user"
    if os.stat(PROJECT).st_mode & 0o005 != 0o005:
        return "", "the project is closed to other users"
    check = "import sys, numpy; assert sys.version_info >= (3, 11)"
    for python in (sys.executable, SYSTEM_PYTHON):
        if not subprocess.run([*ORDINARY, python, "-c", check], capture_output=True, check=False).returncode:
            return python, ""
    return "", "no Python of an ordinary user has numpy and is 3.11 or later"
