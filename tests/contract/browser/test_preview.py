"""An author's first hour, in a real browser: skeletons are written, looked at, broken, mended, tried and checked."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from server.authoring import new
from tests.contract.browser.conftest import ROOT, sync_api
from tests.contract.browser.test_accessibility import check_page

expect = sync_api.expect
pytestmark = [pytest.mark.slow, pytest.mark.long]
START_SECONDS = 300


@pytest.fixture
def place(tmp_path: Path) -> Path:
    folder = tmp_path / "commande"
    for kind, name in (
        ("module", "l21"),
        ("page", "l21/premiers-pas"),
        ("exercise", "l21/gain"),
        ("choice", "l21/quiz"),
    ):
        new.write_skeleton(kind, name, folder)
    return folder


@pytest.fixture
def address(place: Path, tmp_path: Path) -> Iterator[str]:
    machine = {name: value for name, value in os.environ.items() if not name.startswith("BALISE_")}
    with (tmp_path / "log.txt").open("w+") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "server", "preview", str(place), "--port", "0"],
            cwd=ROOT, env={**machine, "PYTHONUNBUFFERED": "1"}, stdout=log, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            yield _address(process, tmp_path / "log.txt")
        finally:
            process.terminate()
            process.wait(300)


def replace(path: Path, old: str, fresh: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, fresh), encoding="utf-8")


def test_the_first_hour_of_an_author(place: Path, address: str, browser: Any) -> None:
    page = browser.new_page(viewport={"width": 900, "height": 500})
    page.set_default_timeout(30_000)
    lesson = place / "curriculum" / "l21" / "seances" / "premiers-pas.md"
    page.goto(f"{address}/l21/lire/premiers-pas")
    foot = page.locator("#apercu")
    expect(foot).to_contain_text("rien à corriger")

    # A change is seen at once, where one was.
    page.evaluate("scrollTo({top: 260, behavior: 'instant'})")
    replace(lesson, "Une cellule s’exécute", "Cette cellule-ci s’exécute")
    expect(page.get_by_text("Cette cellule-ci s’exécute")).to_be_visible()
    page.wait_for_function("() => Math.abs(scrollY - 260) < 60")

    # What is wrong is told in the page, with its file and line.
    replace(lesson, "## Une idée", "## Une idée\n\nVoyez [](page:nulle-part).")
    expect(foot).to_contain_text("curriculum/l21/seances/premiers-pas.md:")
    expect(foot).to_contain_text("nulle-part")
    replace(lesson, "Voyez [](page:nulle-part).", "")
    expect(foot).to_contain_text("rien à corriger")

    # A known mistake, at a click: what a student would see.
    page.goto(f"{address}/l21/exercices/gain")
    foot.get_by_role("link", name=re.compile("Essayer")).click()
    expect(page.get_by_text("gain(2, 10, 0,25)")).to_be_visible()
    page.get_by_role("button", name="Essayer : erreur bouts_echanges").click()
    expect(page.get_by_role("heading", name="Le départ et l’arrivée sont échangés")).to_be_visible()
    page.wait_for_function("() => [...document.querySelectorAll('.figure img')].some((one) => one.naturalWidth > 0)")
    attempt = page.url

    # The grader's own code is read again, in a fresh interpreter: a mistake of the author's, then another solution.
    grader = place / "graders" / "l21" / "gain" / "grader.py"
    replace(grader, "points=12,", "points=11,")
    expect(foot).to_contain_text("graders/l21/gain/grader.py")
    expect(foot).to_contain_text("19")
    replace(grader, "points=11,", "points=12,")
    replace(grader, "yield 2.0, 10.0, 0.25", "yield 2.0, 10.0, 0.5")
    page.goto(f"{address}/apercu/l21/gain")
    expect(page.get_by_text("gain(2, 10, 0,5)")).to_be_visible()
    page.get_by_role("button", name="Essayer : référence").click()
    expect(page.locator(".score")).to_contain_text("20")
    assert page.url != attempt
    page.goto(f"{address}/apercu/l21/quiz")
    page.get_by_role("button", name="Essayer : chemin : deux").click()
    expect(page.get_by_role("heading", name="Le point de départ est oublié")).to_be_visible()
    page.close()


def test_axe_finds_nothing_on_what_the_preview_adds(place: Path, address: str, browser: Any) -> None:
    page = browser.new_page(viewport={"width": 390, "height": 800})
    page.set_default_timeout(30_000)
    lesson = place / "curriculum" / "l21" / "seances" / "premiers-pas.md"
    page.goto(f"{address}/l21/lire/premiers-pas")
    expect(page.locator("#apercu")).to_contain_text("rien à corriger")
    replace(lesson, "## Une idée", "## Une idée\n\nVoyez [](page:nulle-part).")
    expect(page.locator("#apercu"), "the page has come back by itself").to_contain_text("nulle-part")
    for path in ("/l21/lire/premiers-pas", "/apercu/l21/gain", "/apercu/l21/quiz"):
        page.goto(f"{address}{path}")
        expect(page.locator("#apercu")).to_contain_text("nulle-part")
        page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
        check_page(page, path)
        wide = page.evaluate("document.documentElement.scrollWidth")
        assert wide <= 390, (path, wide)
    page.close()


def test_what_stops_python_leaves_the_preview_standing(place: Path, address: str, browser: Any) -> None:
    page = browser.new_page()
    page.set_default_timeout(30_000)
    page.goto(f"{address}/l21")
    foot = page.locator("#apercu")
    expect(foot).to_contain_text("rien à corriger")
    grader = place / "graders" / "l21" / "gain" / "grader.py"
    good = grader.read_text(encoding="utf-8")
    for bad, said in (
        ("raise SystemExit('adieu')\n", "SystemExit"),
        ("def (:\n", "grader.py:1"),
        ("1 / 0\n", "ZeroDiv"),
    ):
        grader.write_text(bad + good, encoding="utf-8")
        expect(foot).to_contain_text(said)
    grader.write_text(good, encoding="utf-8")
    expect(foot).to_contain_text("rien à corriger")
    page.close()


def test_a_course_that_was_written_is_checked_and_served(place: Path, tmp_path: Path) -> None:
    machine = {name: value for name, value in os.environ.items() if not name.startswith("BALISE_")}
    environment = {**machine, "XDG_CACHE_HOME": str(tmp_path / "cache"), "PYTHONUNBUFFERED": "1"}
    checked = subprocess.run(
        [sys.executable, "-m", "server", "check", "--course", str(place)],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert "erreur bouts_echanges" in checked.stdout
    assert "l20/" not in checked.stdout, "the author's course alone"
    served = {**environment, "BALISE_COURSES": str(place), "BALISE_WORKERS": "1"}
    with (tmp_path / "serve.txt").open("w+") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(tmp_path / "data")],
            cwd=ROOT, env=served, stdout=log, stderr=subprocess.STDOUT,
        )  # fmt: skip
        try:
            address = _address(process, tmp_path / "serve.txt")
            with httpx.Client(base_url=address, follow_redirects=True, timeout=30) as client:
                assert "Titre du module L21" in client.get("/").text
                wrong = "def gain(a, b, t):\n    return b + t * (a - b)\n"
                attempt = client.post("/l21/exercices/gain/soumissions", data={"code": wrong})
                deadline = time.monotonic() + START_SECONDS
                while "sont échangés" not in attempt.text and time.monotonic() < deadline:
                    time.sleep(0.1)
                    attempt = client.get(str(attempt.url))
                assert "Le départ et l’arrivée sont échangés" in attempt.text
                figure = re.search(r'src="([^"]+/figures/[^"]+light)"', attempt.text)
                assert figure
                assert "<svg" in client.get(figure[1].replace("&amp;", "&")).text
        finally:
            process.terminate()
            process.wait(300)


def _address(process: subprocess.Popen[bytes], log: Path) -> str:
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        told = re.search(r"http://127\.0\.0\.1:\d+", log.read_text(encoding="utf-8"))
        if told:
            return told[0]
        time.sleep(0.05)
    pytest.fail(log.read_text(encoding="utf-8"))
