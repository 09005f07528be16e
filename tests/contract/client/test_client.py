"""The client of one file against a real service, as students run it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import httpx
import pytest

from server.base.files import ROOT
from server.base.settings import Settings
from server.identity import tokens
from server.identity.models import Account, Role
from tests.support.live import until
from tests.support.quick import the_course
from tests.support.served import Server

EXERCISE = "l20/poses"
RECIPES = ROOT / "server" / "docs" / "client.md"
RUN = re.compile(r"^\s+-? ?(?:run: )?(python3 balise\.pyz .*)$", re.MULTILINE)


class Student:
    """A folder with the client, and its environment."""

    def __init__(self, folder: Path, server: Server) -> None:
        self.folder, self.server = folder, server
        client = folder / "balise.pyz"
        client.write_bytes(httpx.get(f"{server.address}/client/balise.pyz").content)
        self.environment = {
            "PATH": os.environ["PATH"], "HOME": str(folder), "XDG_CONFIG_HOME": str(folder / "config"),
        }  # fmt: skip

    def start(self, *arguments: str, **options: Any) -> subprocess.Popen[str]:
        command = [sys.executable, "-I", "balise.pyz", *arguments]
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen(command, cwd=self.folder, env=self.environment, **streams, **options)

    def run(self, *arguments: str, typed: str = "") -> tuple[int, str, str]:
        process = self.start(*arguments, stdin=subprocess.PIPE)
        out, err = process.communicate(typed, timeout=300)
        return process.returncode, out, err


@pytest.fixture(scope="module")
def token(server: Server) -> str:
    with closing(server.open_database()) as database, database.write() as db:
        account = Account(role=Role.teacher, name="Mme Martin")
        db.add(account)
        db.flush()
        _, secret = tokens.create_token(db, account, "essai", Settings())
    return secret


@pytest.fixture
def student(server: Server, token: str, tmp_path: Path) -> Student:
    made = Student(tmp_path, server)
    assert made.run("login", typed=f"{token}\n")[0] == 0
    return made


def test_from_login_to_full_marks(student: Student) -> None:
    assert student.run("--version")[1].startswith("balise.pyz ")
    status, out, _ = student.run("list")
    assert status == 0
    assert EXERCISE in out
    assert student.run("get", EXERCISE)[0] == 0
    assert student.run("get", EXERCISE)[0] == 0, "what is there already is the same"
    file = student.folder / "poses.py"
    assert file.read_text().startswith(f"# balise: {EXERCISE}\n")
    status, out, _ = student.run("submit", "poses.py")
    assert status == 1
    assert "/20" in out
    assert f"{student.server.address}/soumissions/" in out
    file.write_text(the_course().exercises[EXERCISE].solution)
    status, out, err = student.run("submit", "poses", "poses.py")
    assert (status, err) == (0, ""), out
    assert f"{EXERCISE} : 20/20" in out
    (student.folder / "poses.py").unlink()
    assert student.run("get", EXERCISE, "--last")[0] == 0
    assert the_course().exercises[EXERCISE].solution in file.read_text()
    assert student.run("get", EXERCISE)[0] == 2, "nothing is replaced"


def test_a_mistyped_exercise_is_refused_with_near_names(student: Student) -> None:
    status, _, err = student.run("get", "l20/pose")
    assert status == 2
    assert f"Vouliez-vous dire {EXERCISE}" in err
    status, out, err = run_in_notebook(student, "l20/pose", "x = 1\n")
    assert f"Vouliez-vous dire {EXERCISE}" in out
    assert student.run("submit", "absent.py")[2].startswith("balise : absent.py n’existe pas dans le dossier ")


def test_a_save_is_sent(student: Student) -> None:
    file = student.folder / "poses.py"
    file.write_text("x = 1\n")
    process = student.start("watch", "poses.py")
    assert process.stdout
    seen = [process.stdout.readline() for _ in range(2)]
    assert "enregistrement" in seen[0]
    file.write_text(the_course().exercises[EXERCISE].solution)
    until(lambda: "20/20" in process.stdout.readline(), "the verdict of the second save")
    process.terminate()
    process.communicate()


def test_an_editor_reads_the_problems(student: Student) -> None:
    (student.folder / "poses.py").write_text("def composer(a, b):\n    return a +\n")
    assert student.run("vscode")[0] == 0
    task = json.loads((student.folder / ".vscode" / "tasks.json").read_text())["tasks"][0]
    arguments = [argument.replace("${file}", str(student.folder / "poses.py")) for argument in task["args"][1:]]
    status, out, _ = student.run(*arguments)
    assert status == 1
    problem = re.compile(task["problemMatcher"]["pattern"]["regexp"], re.MULTILINE).search(out)
    assert problem, out
    assert (problem[1], problem[2]) == (str(student.folder / "poses.py"), "2")


def run_in_notebook(student: Student, exercise: str, cell: str) -> tuple[int, str, str]:
    """Run a cell under the magic command; print its verdict as a notebook shows it."""
    script = """
import sys
sys.path.insert(0, "balise.pyz")
import balise
class Shell:
    def run_cell(self, cell): exec(cell, {})
    def register_magic_function(self, function, kind, name): self.magic = function
shell = Shell()
balise.load_ipython_extension(shell)
verdict = shell.magic(sys.argv[1], sys.argv[2])
print(verdict._repr_html_() if verdict else "")
"""
    done = subprocess.run(
        [sys.executable, "-c", script, exercise, cell], cwd=student.folder, env=student.environment,
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def test_a_notebook_shows_the_verdict_with_its_figure(student: Student) -> None:
    wrong = the_course().exercises[EXERCISE].solution.replace("cos", "sin")
    status, out, err = run_in_notebook(student, EXERCISE, wrong)
    assert status == 0, err
    assert "/20" in out
    assert "data:image/svg+xml;base64," in out
    assert "/soumissions/" in out


def test_the_recipes_of_continuous_integration_run(student: Student, token: str) -> None:
    (student.folder / "poses.py").write_text(the_course().exercises[EXERCISE].solution)
    student.environment["BALISE_TOKEN"] = token
    commands = RUN.findall(RECIPES.read_text(encoding="utf-8"))
    assert len(commands) >= 2, "GitHub's and GitLab's"
    for command in commands:
        status, out, err = student.run(*command.split()[2:])
        assert status == 0, (command, out, err)


def test_no_token_and_no_server_are_said(student: Student) -> None:
    student.environment["XDG_CONFIG_HOME"] = str(student.folder / "nobody")
    status, _, err = student.run("list")
    assert (status, "/compte" in err) == (2, True)
    status, _, err = student.run("login", "--server", "http://127.0.0.1:9", typed="x\n")
    assert (status, "impossible de joindre" in err) == (2, True)
