"""README.md tells every room of the server, as each tells itself; and every dependency, with what it is for."""

from __future__ import annotations

import ast
import re
import subprocess
import tomllib

import pytest

from server.base.paths import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
ROOMS = dict(re.findall(r"^\| `(\w+)/` \| (.+) \|$", README.split("| room | holds |")[1].split("\n\n")[0], re.M))


def rooms() -> set[str]:
    """The folders of `server/` that hold something of ours, and not only what a build or Python leaves."""
    listed = subprocess.run(["git", "ls-files", "server"], cwd=ROOT, capture_output=True, text=True, check=False)
    names = [line.split("/") for line in listed.stdout.splitlines()]
    if not names:
        pytest.skip("not a git checkout")
    for_administrators = {"docs", "deploy"}  # pages, and files to deploy with
    return {parts[1] for parts in names if len(parts) > 2} - for_administrators


def test_every_room_is_in_the_table_and_nothing_else() -> None:
    assert ROOMS.keys() == rooms()
    assert list(ROOMS) == sorted(ROOMS)


@pytest.mark.parametrize("room", sorted(ROOMS.keys() - {"frontend"}))
def test_a_room_says_of_itself_what_the_table_says(room: str) -> None:
    source = (ROOT / "server" / room / "__init__.py").read_text(encoding="utf-8")
    said = ast.get_docstring(ast.parse(source)) or ""
    assert said.removesuffix(" See README.md in this folder.") == ROOMS[room]


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_the_tests_of_a_room_stand_in_its_folder(room: str) -> None:
    """The front end has none of its own: it is tried in a browser."""
    folder = ROOT / "tests" / {"frontend": "browser"}.get(room, room)
    assert [*folder.glob("test_*.py")]


def test_no_folder_of_tests_is_left_of_a_room_that_is_no_more() -> None:
    others = {"app", "benchmarks", "browser", "curriculum", "deploy", "fuzz", "graders", "hostile", "reference"}
    others |= {"support"}
    folders = {path.parent.name for path in (ROOT / "tests").glob("*/*.py")} | {"hostile"}
    assert folders - others == rooms() - {"frontend"}


def test_every_dependency_has_its_reason() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = [*project["dependencies"], *(one for extra in project["optional-dependencies"].values() for one in extra)]
    names = {re.split(r"[\[<>=]", one)[0] for one in needed} - {"balise"}
    table = README.split("## Dependencies, and why")[1]
    cells = " ".join(line.split("|")[1] for line in table.splitlines() if line.startswith("|"))
    missing = {name for name in names if not re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", cells)}
    assert missing == set()
    assert len(names) > 20


def test_every_path_that_the_readme_names_is_there() -> None:
    paths = {path for path in re.findall(r"`([\w./]+/[\w./]*)`", README) if "<" not in path}
    links = set(re.findall(r"\]\(([\w./]+)\)", README))
    tops = {path.name for path in ROOT.iterdir()}
    missing = {path for path in paths | links if path.split("/")[0] in tops and not (ROOT / path).exists()}
    assert missing == set()
    assert links
