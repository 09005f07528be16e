"""The contributors' pages name every room, dependency and layer as the code has them, and no link is dead."""

from __future__ import annotations

import ast
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

from server.base.files import ROOT
from tests.support.tables import folded

DEV = ROOT / "server" / "docs" / "dev"
README_BYTES = 12_000
#: Where the tests of a room may stand: the platform, the content and the contracts.
PARTS = (ROOT / "tests", ROOT / "tests" / "content", ROOT / "tests" / "contract")
ROOMS = dict(re.findall(r"^\| `(\w+)/` \| (.+) \|$", (DEV / "rooms.md").read_text(encoding="utf-8"), re.M))
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / ".github").glob("*.md"), *DEV.rglob("*.md")]


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


@folded("room", sorted(ROOMS.keys() - {"frontend"}))
def test_a_room_says_of_itself_what_the_table_says(room: str) -> None:
    source = (ROOT / "server" / room / "__init__.py").read_text(encoding="utf-8")
    said = ast.get_docstring(ast.parse(source)) or ""
    assert said.removesuffix(" See README.md in this folder.") == ROOMS[room]


@folded("room", sorted(ROOMS))
def test_each_room_has_tests_in_a_folder_of_its_name(room: str) -> None:
    """In one of the three parts of the suite; the front end's tests run in a browser."""
    folder = {"frontend": "browser"}.get(room, room)
    assert any([*(part / folder).glob("test_*.py")] for part in PARTS)


def test_each_folder_of_tests_belongs_to_a_room() -> None:
    others = {"app", "benchmarks", "browser", "content", "contract", "curriculum", "deploy", "fuzz", "graders"}
    others |= {"gate", "hostile", "reference", "support"}
    folders = {path.parent.name for part in PARTS for path in part.glob("*/*.py")}
    assert folders - others <= rooms() - {"frontend"}


def test_every_dependency_has_its_reason() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"].values()
    requirements = [*project["dependencies"], *(requirement for extra in extras for requirement in extra)]
    names = {re.split(r"[\[<>=]", requirement)[0] for requirement in requirements} - {"balise"}
    table = (DEV / "dependencies.md").read_text(encoding="utf-8")
    cells = " ".join(line.split("|")[1] for line in table.splitlines() if line.startswith("|"))
    missing = {name for name in names if not re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", cells)}
    assert missing == set()
    assert len(names) > 20


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_bytes()) <= README_BYTES


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_paths_and_links_of_a_page_exist(page: Path) -> None:
    """Relative links, with their headings, and paths in backquotes that begin at the top level."""
    text = page.read_text(encoding="utf-8")
    tops = {path.name for path in ROOT.iterdir()}
    paths = {path for path in re.findall(r"`([\w./]+/[\w./]*)`", text) if path.split("/")[0] in tops}
    assert {path for path in paths if not (ROOT / path).exists()} == set()
    for target, heading in re.findall(r"\]\(([\w./-]*)(?:#([\w-]+))?\)", text):
        linked = page.parent / target if target else page
        assert linked.exists(), target
        if heading:
            assert heading in _anchors(linked), f"{target}#{heading}"


def _anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_every_decision_is_in_the_index() -> None:
    decisions = {path.name for path in (DEV / "decisions").glob("*.md")} - {"README.md"}
    index = (DEV / "decisions" / "README.md").read_text(encoding="utf-8")
    assert decisions == set(re.findall(r"\]\((\d+[\w-]+\.md)\)", index))
    assert decisions


def test_the_diagram_shows_the_import_contracts() -> None:
    """The boxes and arrows of the architecture page are the layers that import-linter enforces."""
    diagram = re.findall(r"```mermaid\n(.*?)```", (DEV / "architecture.md").read_text(encoding="utf-8"), re.S)
    assert len(diagram) == 1
    boxes = dict(re.findall(r"^\s*(\w+)\[\"(.+)\"\]$", diagram[0], re.M))
    chains = [line.strip().split(" --> ") for line in diagram[0].splitlines() if " --> " in line]
    drawn = [[sorted(boxes.get(box, box).split(" · ")) for box in chain] for chain in chains]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = [contract for contract in project["tool"]["importlinter"]["contracts"] if contract["type"] == "layers"]
    enforced = [[sorted(layer.split(" | ")) for layer in contract["layers"]] for contract in contracts]
    assert sorted(drawn) == sorted(enforced)
