"""On a kernel that lacks a wall that is needed, nothing is served, and the reason and the mend are told."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
#: Runs the command line under a filter that answers ENOSYS to one system call, as an older kernel would.
WITHOUT = """
import runpy, struct, sys
from server.sandbox.child import libc, seccomp
call = int(sys.argv.pop(1))
instructions = ((0x20, 0, 0, 0), (0x15, 0, 1, call), (0x06, 0, 0, 0x00050000 | 38), (0x06, 0, 0, 0x7FFF0000))
libc.prctl(libc.PR_SET_NO_NEW_PRIVS, 1)
seccomp.install(b"".join(struct.pack("=HBBI", *one) for one in instructions))
sys.argv[0] = "balise"
runpy.run_module("server", run_name="__main__")
"""
LANDLOCK_CREATE_RULESET, CLONE3 = 444, 435


def balise(call: int, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(PROJECT), "PYTHONIOENCODING": "utf-8"}
    command = [sys.executable, "-c", WITHOUT, str(call), *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=300)


@pytest.mark.slow
def test_without_landlock_the_doctor_says_so_and_what_to_mend() -> None:
    told = balise(LANDLOCK_CREATE_RULESET, "doctor")
    assert told.returncode == 1
    lines = told.stdout.splitlines()
    at = next(k for k, line in enumerate(lines) if "landlock-lecture" in line)
    assert lines[at].strip().startswith("✗")
    assert "remède" in lines[at + 1]
    assert "lsm=" in lines[at + 1]
    assert "ne peut PAS" in lines[-1]


@pytest.mark.slow
def test_without_landlock_nothing_is_served(tmp_path: Path) -> None:
    told = balise(LANDLOCK_CREATE_RULESET, "serve", "--port", "0", "--data", str(tmp_path))
    assert told.returncode == 2
    assert "landlock-lecture" in told.stderr
    assert "remède" in told.stderr


@pytest.mark.slow
def test_where_forks_may_have_no_namespaces_of_their_own_files_are_graded() -> None:
    told = balise(CLONE3, "grade", "l20/poses", str(PROJECT / "graders/l20/poses/solution.py"))
    assert told.returncode == 0, told.stderr
