"""The sandbox stands for whoever runs it: an ordinary user, or one of the few of a container."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
SYSTEM_PYTHON = "/usr/bin/python3"
AS_ANOTHER = """
import sys
from server.sandbox import Sandbox, ProgramFault, probe, safe_to_serve
reports = probe(slow=False)
assert safe_to_serve(reports), reports
with Sandbox({}) as sandbox, sandbox.open(b"import numpy as np\\ndef f(x):\\n    return x + np.ones(1)\\n") as session:
    assert session.call("f", 1).value.tolist() == [2.0]
print("tenu")
"""


@pytest.mark.parametrize("namespace", ["-Ur", "-U"], ids=["root of one identity", "nobody, without namespaces"])
def test_it_stands_in_a_container_that_has_few_identities(namespace: str) -> None:
    unshare = ["unshare", namespace, "--"]
    if not shutil.which("unshare") or subprocess.run([*unshare, "true"], check=False, capture_output=True).returncode:
        pytest.skip("this machine refuses user namespaces to this user")
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [*unshare, sys.executable, "-c", AS_ANOTHER]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.stdout.strip() == "tenu", done.stderr


def usable_by_nobody() -> str:
    """Why an ordinary user cannot run the sandbox on this machine; "" when one can."""
    if os.geteuid() != 0 or not shutil.which("runuser"):
        return "only root can become another user"
    if not os.path.exists(SYSTEM_PYTHON):
        return "no system Python"
    check = "import sys, numpy; assert sys.version_info >= (3, 11)"
    done = subprocess.run(
        ["runuser", "-u", "nobody", "--", SYSTEM_PYTHON, "-c", check], capture_output=True, check=False
    )
    if done.returncode:
        return "the system Python of an ordinary user has no numpy, or is older than 3.11"
    return "" if os.stat(PROJECT).st_mode & 0o005 == 0o005 else "the project is closed to other users"


def test_it_stands_for_an_ordinary_user() -> None:
    if reason := usable_by_nobody():
        pytest.skip(reason)
    command = [
        "runuser",
        "-u",
        "nobody",
        "--",
        "env",
        "-C",
        str(PROJECT),
        "PYTHONDONTWRITEBYTECODE=1",
        f"PYTHONPATH={PROJECT}",
    ]
    done = subprocess.run([*command, SYSTEM_PYTHON, "-c", AS_ANOTHER], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "tenu", done.stderr
