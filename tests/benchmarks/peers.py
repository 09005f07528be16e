"""What others do with the same file: cold interpreters, with and without bubblewrap, and the graders that teachers use.

The graders are no dependency of the project: they are looked for in a virtual environment made for them,

    python3 -m venv PEERS && PEERS/bin/pip install otter-grader nbgrader ipykernel check50 pytest numpy scipy

and given as ``--peers-venv PEERS``. One that is not there is left out with its reason.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from tests.benchmarks.measure import Contender
from tests.benchmarks.programs import Program

QUIET = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
BWRAP = (
    "--unshare-all --die-with-parent --new-session --clearenv --setenv OPENBLAS_NUM_THREADS 1 "
    "--ro-bind / / --proc /proc --dev /dev --chdir /"
)


class Missing(Exception):
    """Why a peer is not there."""


def run(*command: str, folder: Path, bin_folder: Path | None = None) -> str:
    """Runs a command to its end; raises Missing, with what it said, when it fails."""
    path = f"{bin_folder}:{os.environ['PATH']}" if bin_folder else os.environ["PATH"]
    environment = {**os.environ, **QUIET, "PATH": path, "PYTHONPATH": ""}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Missing(f"`{' '.join(command[:3])}` says: {(done.stdout + done.stderr).strip()[-300:]}")
    return done.stdout


def cold(program: Program, folder: Path, *wrapper: str) -> Callable[[], float]:
    """A fresh interpreter that loads the file and calls its function."""
    script = f"import sys; sys.path[:0] = {[p for p in sys.path if p.endswith('-packages')]!r}\n"
    script += program.source + program.test

    def action() -> float:
        run(*wrapper, sys.executable, "-I", "-S", "-c", script, folder=folder)
        return 0.0

    return action


def bubblewrapped(program: Program, folder: Path, _: Path) -> Callable[[], float]:
    found = shutil.which("bwrap")
    if found is None:
        raise Missing("bubblewrap is not installed")
    return cold(program, folder, found, *BWRAP.split())


def pytest_alone(program: Program, folder: Path, bin_folder: Path) -> Callable[[], float]:
    (folder / "solution.py").write_text(program.source)
    body = program.test.replace("\n", "\n    ").strip()
    (folder / "test_solution.py").write_text(f"from solution import *\n\ndef test_it():\n    {body}\n")
    command = [tool(bin_folder, "python"), "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_solution.py"]

    def action() -> float:
        run(*command, folder=folder, bin_folder=bin_folder)
        return 0.0

    return action


def check50(program: Program, folder: Path, bin_folder: Path) -> Callable[[], float]:
    checks, work = folder / "checks", folder / "work"
    checks.mkdir()
    work.mkdir()
    (work / "solution.py").write_text(program.source)
    (checks / ".cs50.yml").write_text("check50:\n  files:\n    - !exclude '*'\n    - !require solution.py\n")
    body = program.test.replace("\n", "\n    ").strip()
    (checks / "__init__.py").write_text(
        "import check50\n\n@check50.check()\ndef it():\n    '''the answer holds'''\n"
        f"    from check50.py import import_\n    {program.function} = import_('solution.py').{program.function}\n"
        f"    {body}\n"
    )
    command = [tool(bin_folder, "check50"), "--offline", "--dev", "--log-level", "warning", "-o", "json"]

    def action() -> float:
        said = json.loads(run(*command, "--", str(checks), folder=work, bin_folder=bin_folder))
        if not all(one["passed"] for one in said.get("results", [{"passed": False}])):
            raise Missing(f"check50 finds the answer wrong: {said}")
        return 0.0

    return action


def otter(program: Program, folder: Path, bin_folder: Path) -> Callable[[], float]:
    tests = folder / "tests"
    tests.mkdir()
    case = "".join(f">>> {line}\n" for line in program.test.splitlines())
    suite = {"type": "doctest", "cases": [{"code": case, "hidden": False, "locked": False}]}
    (tests / "q1.py").write_text(f"OK_FORMAT = True\ntest = {{'name': 'q1', 'points': 1, 'suites': [{suite!r}]}}\n")
    (folder / "solution.py").write_text(program.source)
    command = tool(bin_folder, "otter")
    run(command, "generate", "-t", "tests", "--no-environment", folder=folder, bin_folder=bin_folder)
    archive = next(folder.glob("*.zip")).name

    def action() -> float:
        run(command, "run", "--no-logo", "-a", archive, "solution.py", folder=folder, bin_folder=bin_folder)
        result = json.loads((folder / "results.json").read_text())
        if not any(one.get("score") == one.get("max_score") == 1 for one in result["tests"]):
            raise Missing(f"otter-grader finds the answer wrong: {str(result)[:300]}")
        return 0.0

    return action


def nbgrader(program: Program, folder: Path, bin_folder: Path) -> Callable[[], float]:
    command = tool(bin_folder, "nbgrader")
    notebook(folder / "source" / "ps1" / "p1.ipynb", program)
    (folder / "nbgrader_config.py").write_text("c = get_config()\nc.CourseDirectory.course_id = 'course'\n")
    run(command, "generate_assignment", "ps1", "--create", folder=folder, bin_folder=bin_folder)
    notebook(folder / "submitted" / "ada" / "ps1" / "p1.ipynb", program)

    def action() -> float:
        run(command, "autograde", "ps1", "--student", "ada", "--force", folder=folder, bin_folder=bin_folder)
        graded = (folder / "autograded" / "ada" / "ps1" / "p1.ipynb").read_text()
        if '"output_type": "error"' in graded:
            raise Missing("nbgrader finds the answer wrong")
        return 0.0

    return action


def notebook(path: Path, program: Program) -> None:
    """A notebook of one cell to write and one cell of tests, as nbgrader marks them."""

    def cell(name: str, source: str, **marks: object) -> dict[str, object]:
        mark = {"grade": False, "grade_id": name, "locked": False, "schema_version": 3, "task": False, **marks}
        return {
            "cell_type": "code",
            "execution_count": None,
            "id": name,
            "metadata": {"nbgrader": mark},
            "outputs": [],
            "source": source,
        }

    cells = [
        cell("solution", program.source, solution=True),
        cell("tests", program.test, solution=False, grade=True, locked=True, points=1),
    ]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        json.dumps({"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5})
    )


def tool(bin_folder: Path, name: str) -> str:
    found = shutil.which(name, path=str(bin_folder))
    if found is None:
        raise Missing(f"{name} is not in {bin_folder}")
    return found


#: Name, how to make it ready, and in how many rounds it runs once: the slow ones more rarely.
PEERS: tuple[tuple[str, Callable[[Program, Path, Path], Callable[[], float]], int], ...] = (
    ("plain cold Python", lambda program, folder, _: cold(program, folder), 5),
    ("bubblewrap + cold Python", bubblewrapped, 5),
    ("pytest in a process", pytest_alone, 20),
    ("check50", check50, 20),
    ("otter-grader", otter, 40),
    ("nbgrader autograde", nbgrader, 40),
)


def peers(program: Program, folder: Path, bin_folder: Path) -> Iterator[Contender]:
    """The peers that answer rightly here; the others are named with their reason on the error stream."""
    for name, prepare, every in PEERS:
        own = folder / name.replace(" ", "-")
        own.mkdir(parents=True)
        try:
            action = prepare(program, own, bin_folder)
            action()
        except Missing as reason:
            print(f"left out: {name} ({reason})", file=sys.stderr)
        else:
            yield Contender(name, action, every)
