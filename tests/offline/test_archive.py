"""A module's archive: nothing in it asks for what is not in it, and nothing for the network."""

from __future__ import annotations

import asyncio
import io
import json
import posixpath
import re
import zipfile
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urldefrag

import pytest

from server.base.errors import NotFound, Overloaded, WrongMoment
from server.course import Module
from server.offline import site
from server.offline.addresses import ON_THE_SERVER, ArchiveLinkRewriter
from server.offline.service import OfflineArchives
from server.reading.downloads import DownloadArchives
from tests.support.quick import the_course

NO_ADDRESS = ("http:", "https:", "data:", "mailto:")
PICTURE = b"<svg xmlns='http://www.w3.org/2000/svg'/>"


class Page(HTMLParser):
    """What a page asks for, the places in it, its headings, and its pictures without a text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.asked: list[tuple[str, str]] = []
        self.places: set[str] = set()
        self.levels: list[int] = []
        self.mute: list[str] = []
        self.landmarks: set[str] = set()
        self.maths = [0, 0]
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.places |= {given.get("id") or ""}
        self.asked += [
            (name, value or "")
            for name, value in attrs
            if name in {"href", "src", "data-source", "data-hands", "srcset"}
        ]
        if re.fullmatch("h[1-6]", tag):
            self.levels.append(int(tag[1]))
        if tag == "img" and given.get("alt") is None:
            self.mute.append(given.get("src") or "")
        if tag in {"header", "nav", "main", "footer", "article"}:
            self.landmarks.add(tag)
        classes = (given.get("class") or "").split()
        self.maths[0] += "katex" in classes
        self.maths[1] += tag == "math"


def lessened(module: Module) -> Module:
    """The module with a part of its texts: all of them take seconds."""
    kept = {"slam", "poses", "boucles", "demo_1", "verification"}
    lessons = tuple(lesson for lesson in module.lessons if lesson.slug in kept)
    return replace(
        module, lessons=lessons, exercises=tuple(one for one in module.exercises if one.slug in kept), files={}
    )


@cache
def opened() -> dict[str, bytes]:
    course = the_course()
    module = lessened(course.modules["l20"])
    pictures = dict.fromkeys(site.list_needed_pictures(module), PICTURE)
    with zipfile.ZipFile(
        io.BytesIO(site.build_archive_zip(course, module, pictures, DownloadArchives(course)))
    ) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


@cache
def pages() -> dict[str, Page]:
    return {name: Page(text.decode()) for name, text in opened().items() if name.endswith(".html")}


def fault(name: str, address: str) -> str:
    """What is wrong with an address of a page, or nothing."""
    if address.startswith(NO_ADDRESS):
        return "" if address.startswith("https:") else "strange"
    path, place = urldefrag(address)
    if path.startswith("/"):
        return "begins at the root"
    target = posixpath.normpath(posixpath.join(posixpath.dirname(name), unquote(path))) if path else name
    if target not in opened():
        return "is not there"
    return "" if not place or target not in pages() or unquote(place) in pages()[target].places else "no such place"


def test_all_that_a_page_asks_for_is_in_the_archive() -> None:
    wrong = [(name, asked, fault(name, asked)) for name, page in pages().items() for _, asked in page.asked]
    assert [one for one in wrong if one[2]] == []
    assert {"balise-l20/index.html", "balise-l20/lire/slam.html", "balise-l20/exercices/poses.html"} <= pages().keys()
    assert sum(name.startswith("balise-l20/figures/") for name in opened()) > 10


def test_a_manipulation_that_needs_no_server_comes_along() -> None:
    """`ressorts` follows the hand by its own scripts; `particules` has a filter run by the service."""
    assert [name for name in opened() if "/manipulations/" in name] == ["balise-l20/manipulations/ressorts.js"]
    text = opened()["balise-l20/manipulations/ressorts.js"].decode()
    start, brought = text.removesuffix(";\n").split(" = ", 1)
    assert start == 'globalThis.baliseHands["ressorts"]'
    assert json.loads(brought)["scripts"].keys() == {"main.js", "calcul.js"}
    course = the_course()
    whole = site.OfflineSite(course, course.modules["l20"], {}, DownloadArchives(course))
    alone = set(whole._serverless_manipulation_names())
    assert alone >= {"elastique", "passant", "ressorts"}
    assert alone.isdisjoint({"carte", "particules"})


def test_nothing_is_asked_of_the_network() -> None:
    remote = [
        asked
        for page in pages().values()
        for name, asked in page.asked
        if name != "href" and asked.startswith(("http", "//"))
    ]
    assert remote == []
    for name, content in opened().items():
        if name.endswith(".css"):
            sheet = content.decode()
            asked = re.findall(r"url\(([^)]+)\)|@import\s+\"([^\"]+)\"", sheet)
            for one in (first or second for first, second in asked):
                if not one.strip("\"'").startswith("data:"):
                    target = posixpath.normpath(posixpath.join(posixpath.dirname(name), one.strip("\"'")))
                    assert target in opened(), one


def test_scripts_are_plain_ones() -> None:
    """Browsers refuse modules, and fetching, to a page of a folder."""
    for name, content in opened().items():
        if name.endswith(".html"):
            assert b'type="module"' not in content, name
    scenes = {name: content for name, content in opened().items() if "/rejeux/" in name}
    assert {name.split("/")[-1] for name in scenes} >= {"graphe.js", "icp.js"}
    for content in scenes.values():
        head, _, scene = content.decode().partition(" = ")
        assert head.startswith("globalThis.baliseScenes[")
        by_settings = json.loads(scene.rstrip("\n;"))
        assert all(one["frames"] for one in by_settings.values())
        begun = by_settings["[]"]
        asked = begun.get("prediction", {"settings": {}})["settings"]
        assert by_settings.keys() == {"[]", json.dumps(sorted(asked.items()), separators=(",", ":"))}


def test_what_needs_the_server_says_so() -> None:
    told = [name for name, page in pages().items() if any(one.endswith(ON_THE_SERVER) for _, one in page.asked)]
    assert told, "links to lessons that were left out"
    text = opened()[f"balise-l20/{ON_THE_SERVER}"].decode()
    assert "demande le serveur" in text


@pytest.mark.parametrize("name", ["index.html", "glossaire.html", "lire/slam.html", "exercices/poses.html"])
def test_a_page_can_be_read_aloud(name: str) -> None:
    page = pages()[f"balise-l20/{name}"]
    assert page.mute == []
    assert page.levels.count(1) == 1
    assert page.levels[0] == 1
    assert all(below - above <= 1 for above, below in zip(page.levels, page.levels[1:], strict=False)), page.levels
    assert {"header", "nav", "main", "footer"} <= page.landmarks
    assert page.maths[0] == page.maths[1], "each formula keeps its MathML"


def test_the_same_course_makes_the_same_bytes() -> None:
    course = the_course()
    module = course.modules["l20"]
    assert site.archive_content_digest(module) == site.archive_content_digest(module)
    made = site.OfflineSite(course, lessened(module), {}, DownloadArchives(course))
    assert list(made._iter_addresses_and_paths())  # the places are told before a page is written
    places = ArchiveLinkRewriter("/static/abc", {"/l20": "index.html", "/l20/lire/slam": "lire/slam.html"})
    text = '<a href="/l20/lire/slam#x">a</a> <a href="/classes">b</a> <img src="/static/abc/i.svg"> <a href="#y">c</a>'
    away = '<a href="slam.html#x">a</a> <a href="../sur-le-serveur.html">b</a>'
    assert places.relative(text, "lire/a.html") == f'{away} <img src="../static/i.svg"> <a href="#y">c</a>'


class Drawn:
    """In the place of the figures' process: draws at once; is full the first time; fails where it is told to."""

    def __init__(self, *, fails: bool = False) -> None:
        self.asked, self.fails = 0, fails

    async def draw_lesson_figure(self, *_: Any) -> bytes:
        self.asked += 1
        if self.fails:
            raise RuntimeError("a drawing of the author's")
        if self.asked == 1:
            raise Overloaded("Plein.", retry_after=1)
        return PICTURE


@pytest.fixture
def quick_site(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.offline.service.RETRY_SECONDS", 0.0)
    monkeypatch.setattr(site, "build_archive_zip", lambda *_: b"PK-made")
    monkeypatch.setattr(site, "archive_content_digest", lambda _module: "abc123")
    monkeypatch.setattr(site, "list_needed_pictures", lambda _module: [("a", "light"), ("a", "dark")])


def told_to_the_end(story: Coroutine[Any, Any, None]) -> None:
    """In a thread of its own: in this one the browser of other tests may have its loop."""
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, story).result()


@pytest.mark.usefixtures("quick_site")
def test_an_archive_is_made_once_and_kept(tmp_path: Path) -> None:
    (tmp_path / "l20-0123.zip").write_bytes(b"an earlier version")
    (tmp_path / "autre.zip").write_bytes(b"somebody's")

    async def story() -> None:
        course, drawn = the_course(), Drawn()
        archives: Any = OfflineArchives(course, drawn, DownloadArchives(course), tmp_path)  # type: ignore[arg-type]
        module = archives.module("l20")
        assert await archives.look(module) is None
        with pytest.raises(WrongMoment):
            await archives.file(module)
        await asyncio.gather(archives.prepare(module), archives.prepare(module))
        await archives.look(module)
        await archives._making["l20"].task
        assert (await archives.file(module)).read_bytes() == b"PK-made"
        assert drawn.asked == 3, "two pictures, one of them again; not once for each who asks"
        await archives.prepare(module)
        assert archives._making == {}
        with pytest.raises(NotFound):
            archives.module("l99")
        await archives.close()

    told_to_the_end(story())
    assert {path.name for path in tmp_path.iterdir()} == {"l20-abc123.zip", "autre.zip"}


@pytest.mark.usefixtures("quick_site")
def test_one_that_fails_is_told_and_may_be_tried_again(tmp_path: Path) -> None:
    async def story() -> None:
        course = the_course()
        archives: Any = OfflineArchives(course, Drawn(fails=True), DownloadArchives(course), tmp_path)  # type: ignore[arg-type]
        module = archives.module("l20")
        await archives.prepare(module)
        first = archives._making["l20"]
        await first.task
        assert (await archives.look(module)).failed
        await archives.prepare(module)
        assert archives._making["l20"] is not first
        await archives.close()

    told_to_the_end(story())
    assert list(tmp_path.iterdir()) == []
