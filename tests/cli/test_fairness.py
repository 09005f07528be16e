"""`balise check --fairness`: what is counted and told of a small folder of programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from server.cli import fairness, main
from server.course import Course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox, WallReport, WallStatus

RIGHT = """# juste
import cmath
def ramener(t): return cmath.phase(cmath.exp(1j * t))
def composer(a, b):
    z = complex(a[0], a[1]) + complex(b[0], b[1]) * cmath.exp(1j * a[2])
    return [z.real, z.imag, ramener(a[2] + b[2])]
def inverse(a):
    z = -complex(a[0], a[1]) * cmath.exp(-1j * a[2])
    return [z.real, z.imag, ramener(-a[2])]
def relatif(a, b): return composer(inverse(a), b)
"""
WRONG = RIGHT.replace("# juste", "# erreur : tourne de -θ").replace("cmath.exp(1j * a[2])", "cmath.exp(-1j * a[2])")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for side in ("right", "wrong"):
        (tmp_path / "poses" / side).mkdir(parents=True)
    (tmp_path / "poses/right/complexes.py").write_text(RIGHT)
    (tmp_path / "poses/wrong/sens.py").write_text(WRONG)
    return tmp_path


@pytest.fixture
def graders(course: Course, course_sandbox: Sandbox) -> SandboxGrader:
    return SandboxGrader(course, course_sandbox)


def run(course: Course, grader: SandboxGrader, folder: Path, capsys: Any) -> tuple[int, list[str]]:
    status = fairness.run_fairness_check(course, grader, folder, 2)
    return status, capsys.readouterr().out.splitlines()


def test_programs_are_counted_and_listed(course: Course, graders: SandboxGrader, folder: Path, capsys: Any) -> None:
    status, lines = run(course, graders, folder, capsys)
    assert (status, lines[-1]) == (0, "refused=0/1 accepted=0/1 named=1/1 varying=0/2")
    assert "✓ poses right/complexes.py : accepté, 20 points — juste" in lines
    assert any(line.startswith("poses sens.py : erreur : tourne de -θ → rotation_a_l_envers (") for line in lines)


def test_a_readers_judgement_is_counted_where_there_is_one(
    course: Course, graders: SandboxGrader, folder: Path, capsys: Any
) -> None:
    first, rest = WRONG.split("\n", 1)
    for names, misnamed, named in (("rotation_a_l_envers, autre", 0, 1), ("aucun", 1, 0)):
        (folder / "poses/wrong/sens.py").write_text(f"{first}\n# nom: {names}\n{rest}")
        _, lines = run(course, graders, folder, capsys)
        assert lines[-2:] == [f"misnamed={misnamed}/1", f"refused=0/1 accepted=0/1 named={named}/1 varying=0/2"]


def test_what_is_unfair_fails(course: Course, graders: SandboxGrader, folder: Path, capsys: Any) -> None:
    (folder / "poses/right/faux.py").write_text(WRONG)
    (folder / "poses/wrong/juste.py").write_text(RIGHT)
    (folder / "poses/wrong/hasard.py").write_text(
        RIGHT.replace("def inverse", "au_hasard = rng.random() < 0.5\ndef inverse").replace(
            "z = -complex", "z = (-1 if au_hasard else 1) * -complex"
        )
    )
    status, lines = run(course, graders, folder, capsys)
    assert status == 1
    assert lines[-1].startswith("refused=1/2 accepted=")
    assert any("wrong/juste.py : accepté, 20 points" in line and line.startswith("✗") for line in lines)


def test_a_folder_of_nothing_is_refused(folder: Path, tmp_path: Path, monkeypatch: Any, capsys: Any) -> None:
    standing = WallReport("seccomp", WallStatus.STANDING, "", required=True)
    monkeypatch.setattr("server.cli.sandboxes.probe", lambda **_: [standing])
    assert main(["check", "--fairness", str(tmp_path / "absent")]) == 2
    assert "n’est pas un dossier" in capsys.readouterr().err
    (folder / "inconnu/right").mkdir(parents=True)
    assert main(["check", "--fairness", str(folder)]) == 2
    assert "ne porte le nom d’aucun exercice" in capsys.readouterr().err
