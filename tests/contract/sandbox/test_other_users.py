"""The sandbox stands for whoever runs it: an ordinary user, or one of the few of a container."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest

from tests.sandbox.users import ORDINARY, PROJECT, python_of_nobody

AS_ANOTHER = """
import sys
from server.sandbox import Sandbox, ProgramFault, probe, is_safe_to_serve
reports = probe(slow=False)
assert is_safe_to_serve(reports), reports
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


def test_it_stands_for_an_ordinary_user() -> None:
    python, reason = python_of_nobody()
    if reason:
        pytest.skip(reason)
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [*ORDINARY, python, "-c", AS_ANOTHER]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=PROJECT, env=environment)
    assert done.stdout.strip() == "tenu", done.stderr
