"""The house rules that a machine can hold: linters, types, one-way imports, sizes."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[1]
CODE = ("reference", "graders", "server")
TOP_LEVEL = {
    "pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md",
    "server", "curriculum", "reference", "graders", "tests", "templates",
}  # fmt: skip


def run(*command: str) -> None:
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]


def test_ruff_finds_nothing() -> None:
    run(sys.executable, "-m", "ruff", "check", ".")


def test_ruff_would_not_reformat() -> None:
    run(sys.executable, "-m", "ruff", "format", "--check", *CODE, "tests")


#: mypy by its API without the collector of garbage, which takes a quarter of its time where it has no cache.
MYPY = """
import gc, os
gc.disable()
gc.enable = gc.disable
from mypy import api
report, errors, status = api.run([])
print(report, errors, flush=True)
os._exit(status)
"""


@pytest.mark.long
@pytest.mark.contract  # a minute without a cache: whoever edits runs mypy by itself
def test_mypy_is_strict_and_content() -> None:
    run(sys.executable, "-c", MYPY)


def test_imports_go_one_way() -> None:
    linter = shutil.which("lint-imports", path=str(Path(sys.executable).parent))
    assert linter, "import-linter is part of the tests extra"
    run(linter, "--no-cache")


def test_top_level_is_as_it_was_drawn() -> None:
    tracked = subprocess.run(
        ["git", "ls-files"], cwd=PROJECT, capture_output=True, text=True, check=False
    ).stdout.splitlines()
    if not tracked:
        pytest.skip("not a git checkout")
    tops = {name.split("/")[0] for name in tracked}
    assert {name for name in tops if not name.startswith(".")} <= TOP_LEVEL


def test_the_front_end_holds_its_sources_alone() -> None:
    """What is built of them, third-party code among it, belongs to no commit."""
    frontend = PROJECT / "server" / "frontend"
    sources = {".npmrc", "build.mjs", "build_hook.py", "package.json", "package-lock.json", "src"}
    assert {path.name for path in frontend.iterdir()} - {"__pycache__", "node_modules"} == sources


def test_files_stay_readable() -> None:
    long = {
        str(path.relative_to(PROJECT)): lines
        for folder in CODE
        for path in (PROJECT / folder).rglob("*.py")
        if "node_modules" not in path.parts and (lines := len(path.read_text(encoding="utf-8").splitlines())) > 350
    }
    assert not long
