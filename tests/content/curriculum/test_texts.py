"""The pages of the course as they are served: whole HTML, links that arrive, cells that run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import urldefrag

import pytest

from server.app import create_app
from server.base.settings import Settings
from server.cells.run import run_cell
from server.course import Course, load_course
from server.sandbox import Sandbox
from tests.support.client import TestClient
from tests.support.quick import migrated, the_course
from tests.support.shipped import MODULES

#: Characters of a line that the editor shows beside the statement in a window of 1280 pixels.
EDITOR_COLUMNS = 66
EMPTY = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
FOREIGN = {"line", "mspace", "path"}  # of SVG and MathML: these may close themselves


class Page(HTMLParser):
    """What a page holds. Raises AssertionError where its elements do not close as they open."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.ids: Counter[str] = Counter()
        self.links: list[str] = []
        self.images: list[tuple[str, str | None]] = []
        self._open: list[str] = []
        self.feed(html)
        self.close()
        assert not self._open, f"left open: {self._open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._look(tag, dict(attrs))
        if tag not in EMPTY:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._look(tag, dict(attrs))
        assert tag in EMPTY | FOREIGN, f"<{tag}> closes itself"

    def handle_endtag(self, tag: str) -> None:
        assert self._open, f"</{tag}> closes nothing"
        opened = self._open.pop()
        assert opened == tag, f"<{opened}> is closed by </{tag}> at {self.getpos()}"

    def _look(self, tag: str, attributes: dict[str, str | None]) -> None:
        if attributes.get("id"):
            self.ids[str(attributes["id"])] += 1
        if tag == "a" and attributes.get("href"):
            self.links.append(str(attributes["href"]))
        if tag == "img":
            self.images.append((str(attributes.get("src")), attributes.get("alt")))


@pytest.fixture(scope="module")
def rendered() -> Course:
    """The course with its texts and formulas drawn: the pages are made of these."""
    return load_course()


@pytest.fixture(scope="module")
def client(rendered: Course, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    settings = Settings(data_dir=Path(tmp_path_factory.mktemp("data")), workers=0)
    database = migrated(settings)
    with TestClient(create_app(settings, course=rendered)) as made:
        yield made
    database.close()


def pages_to_read(module: str) -> list[str]:
    return [f"/{module}/lire/{lesson.slug}" for lesson in the_course().modules[module].lessons]


@cache
def seen(client: TestClient, path: str) -> Page:
    answer = client.get(path)
    assert answer.status_code == 200, path
    return Page(answer.text if answer.headers["content-type"].startswith("text/html") else "")


@pytest.mark.long
def test_every_text_holds_together_and_every_formula_is_drawn(rendered: Course) -> None:
    assert [str(problem) for problem in rendered.problems] == []


@pytest.mark.long
@pytest.mark.parametrize("module", MODULES)
def test_pages_are_whole_and_their_links_arrive(client: TestClient, module: str) -> None:
    exercises = [f"/{module}/exercices/{exercise.slug}" for exercise in the_course().modules[module].exercises]
    for path in [f"/{module}", f"/{module}/glossaire", *pages_to_read(module), *exercises]:
        page = seen(client, path)
        assert [name for name, count in page.ids.items() if count > 1] == [], path
        for link in page.links:
            if link.startswith("https://"):
                continue
            target, anchor = urldefrag(link)
            there = seen(client, target.split("?")[0]) if target else page
            assert not anchor or anchor in there.ids, f"{link} of {path} leads nowhere"


@pytest.mark.long  # beside the test that reads the same pages
@pytest.mark.parametrize("module", MODULES)
def test_every_figure_says_what_it_shows(client: TestClient, module: str) -> None:
    """Drawing them all is the work of `tests/contract/figures/test_drawings.py`."""
    for path in pages_to_read(module):
        for source, alt in seen(client, path).images:
            if "/figures/" in source:
                origin, name = source.split("?")[0].strip("/").split("/figures/")
                assert name.removesuffix(".svg") in the_course().modules[origin].drawings, path
                assert alt, path


@pytest.mark.parametrize("module", MODULES)
def test_every_cell_runs_and_shows_something(course_sandbox: Sandbox, module: str) -> None:
    for lesson in the_course().modules[module].lessons:
        for cell in lesson.cells:
            shown = run_cell(course_sandbox, module, cell.code.encode())
            assert shown.fault is None, (lesson.slug, cell.name, shown.fault)
            assert shown.stdout or shown.figures, (lesson.slug, cell.name)
            assert not shown.truncated, (lesson.slug, cell.name)
            assert len(cell.code.splitlines()) <= 35, (lesson.slug, cell.name, "short enough to be read at a glance")


def test_a_starter_fits_the_editor() -> None:
    lines = [(one.id, line) for one in the_course().exercises.values() for line in one.starter.splitlines()]
    assert [(name, line) for name, line in lines if len(line) > EDITOR_COLUMNS] == []
