"""The archive of a module, opened from a folder: no server, no network, and all that can be read is there."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from server.offline import site
from server.reading.downloads import DownloadArchives
from tests.contract.browser.conftest import Browser, NewVisit, Page, sync_api
from tests.support.quick import the_course

pytestmark = pytest.mark.slow
expect = sync_api.expect

#: What one who hears a page would miss: drawings without words, a level of headings left out, mute formulas.
READ_ALOUD = """() => {
  const main = document.querySelector("main");
  const levels = [...main.querySelectorAll("h1, h2, h3, h4, h5, h6")].map((one) => Number(one.tagName[1]));
  return [
    ...[...document.images].filter((one) => !one.hasAttribute("alt")).map((one) => one.src),
    ...[...main.querySelectorAll("figure.drawing img")].filter((one) => one.alt.length < 20).map((one) => one.src),
    ...levels.filter((level, i) => i > 0 && level > levels[i - 1] + 1).map((level) => `h${level}`),
    ...[...main.querySelectorAll(".katex")].filter((one) => !one.querySelector("math")).map((one) => one.outerHTML),
    ...[...main.querySelectorAll("th:empty, a:not([href])")].map((one) => one.outerHTML),
  ];
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    course = the_course()
    module = course.modules["l20"]
    made = site.build_archive_zip(course, module, site.draw_pictures_in_process(module), DownloadArchives(course))
    where = tmp_path_factory.mktemp("hors ligne é")  # a folder of a pupil's has such a name
    with zipfile.ZipFile(io.BytesIO(made)) as archive:
        archive.extractall(where)
    return where / site.archive_folder_name(module)


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    context = browser.new_context(viewport={"width": 1280, "height": 900}, locale="fr-FR", offline=True)
    opened = context.new_page()
    faults: list[str] = []
    opened.on("console", lambda said: faults.append(said.text) if said.type in {"error", "warning"} else None)
    opened.on("pageerror", lambda error: faults.append(str(error)))
    opened.on("requestfailed", lambda sent: faults.append(f"not there: {sent.url}"))
    opened.on("request", lambda sent: None if sent.url.startswith(("file:", "data:")) else faults.append(sent.url))
    yield opened
    context.close()
    assert faults == []


def test_a_pupil_reads_and_plays_without_a_network(page: Page, folder: Path) -> None:
    page.goto((folder / "index.html").as_uri())
    page.locator("main").get_by_role("link", name="SLAM : se localiser").click()
    expect(page.locator("h1")).to_contain_text("SLAM")
    figure = page.locator("figure.replay").first
    figure.scroll_into_view_if_needed()
    expect(figure.locator("canvas").first).to_be_visible()
    expect(figure.locator(".replay-settings")).to_be_hidden()
    expect(figure.locator(".offline-note")).to_be_visible()
    before = figure.locator(".replay-counter").inner_text()
    figure.get_by_role("button", name="Image précédente").click()
    figure.get_by_role("button", name="Lecture").click()
    expect(figure.locator(".replay-counter")).not_to_have_text(before)
    foretold = page.locator("#rejeu-graphe")  # its prediction is played with other settings than the first
    foretold.scroll_into_view_if_needed()
    foretold.get_by_role("radio").first.check()
    foretold.get_by_role("button", name="Je parie").click()
    expect(foretold.get_by_text("Ce qui arrive :")).to_be_visible(timeout=60_000)
    drawing = page.locator(".drawing img.figure-light").first
    drawing.scroll_into_view_if_needed()
    page.wait_for_function("one => one.complete && one.naturalWidth > 0", arg=drawing.element_handle())
    assert page.evaluate("document.fonts.ready.then(() => document.fonts.check('16px KaTeX_Main'))")
    page.get_by_role("link", name="Glossaire").click()
    expect(page.locator("h1")).to_have_text("Glossaire")


def test_springs_are_in_the_hand_without_a_network(page: Page, folder: Path) -> None:
    page.goto((folder / "lire" / "slam.html").as_uri())
    figure = page.locator("#manipulation-ressorts")
    figure.scroll_into_view_if_needed()
    said = figure.locator(".hands-caption, .replay-caption").first
    expect(said).to_contain_text("2\u202f111")
    figure.get_by_role("button", name="Détendre").click()
    expect(said).to_contain_text("12,2")
    expect(figure.locator(".offline-note")).to_have_count(0)
    page.goto((folder / "lire" / "localiser.html").as_uri())
    expect(page.locator("#manipulation-particules .offline-note")).to_be_visible()


def test_every_page_opens(page: Page, folder: Path) -> None:
    for path in sorted(folder.rglob("*.html")):
        page.goto(path.as_uri())
        expect(page.locator("h1")).to_have_count(1)
        wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert wide <= 0, path.name
        assert page.evaluate(READ_ALOUD) == [], path.name


def test_a_visitor_has_it_prepared_and_takes_it_away(visit: NewVisit) -> None:
    page = visit().open("/l20")
    page.get_by_role("link", name="une archive du module").click()
    page.get_by_role("button", name="Préparer l’archive").click()
    taken = page.get_by_role("link", name="Télécharger l’archive")
    taken.wait_for(timeout=300_000)
    with page.expect_download() as coming:
        taken.click()
    with zipfile.ZipFile(coming.value.path()) as archive:
        assert archive.testzip() is None
        assert "balise-l20/index.html" in archive.namelist()
