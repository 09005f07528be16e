"""A release: reproducible archives that install without Node, in a fresh environment, and serve."""

from __future__ import annotations

import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from server.base.files import ROOT
from server.base.version import VERSION

pytestmark = pytest.mark.slow


def build(folder: Path, *options: str) -> Path:
    subprocess.run([sys.executable, ROOT / ".ci" / "release", "--into", folder, *options], check=True)
    return folder


def test_archives_are_the_same_bytes_each_time_and_hold_the_pages(tmp_path: Path) -> None:
    first, second = (build(tmp_path / name, "--archives-only") for name in ("a", "b"))
    names = sorted(path.name for path in first.iterdir())
    assert names == [f"balise-{VERSION}-py3-none-any.whl", f"balise-{VERSION}.tar.gz"]
    for name in names:
        assert (first / name).read_bytes() == (second / name).read_bytes()
    in_wheel = zipfile.ZipFile(first / names[0]).namelist()
    with tarfile.open(first / names[1]) as archive:
        in_sources = archive.getnames()
    for held in (in_wheel, in_sources):
        assert any(path.endswith("server/static/css/app.css") for path in held)
        assert not any("node_modules" in path or "static.new" in path for path in held)


def test_the_wheel_installs_by_the_constraints_and_grades(tmp_path: Path) -> None:
    dist = build(tmp_path / "dist")
    environment = tmp_path / "env"
    venv.create(environment, with_pip=True)
    pip = [environment / "bin" / "python", "-m", "pip", "install", "--quiet"]
    subprocess.run([*pip, "--require-hashes", "-r", dist / "constraints.txt"], check=True)
    subprocess.run([*pip, "--no-deps", *dist.glob("*.whl")], check=True)
    balise = environment / "bin" / "balise"
    told = subprocess.run([balise, "--version"], capture_output=True, text=True, check=True).stdout
    assert VERSION in told
    solution = ROOT / "graders" / "l20" / "poses" / "solution.py"
    command = [balise, "grade", "l20/poses", solution]
    graded = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert "20/20" in graded.stdout, graded.stderr
    for name in ("constraints.txt", "sbom.cdx.json"):
        assert "://" not in (dist / name).read_text(encoding="utf-8")
