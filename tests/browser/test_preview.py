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

import pytest

from server.authoring import new
from tests.browser.conftest import ROOT, sync_api

expect = sync_api.expect
pytestmark = [pytest.mark.slow, pytest.mark.long]
START_SECONDS = 60


def command(*arguments: str | Path, place: Path) -> list[str]:
    return [sys.executable, "-m", "server", *map(str, arguments)]


@pytest.fixture
def place(tmp_path: Path) -> Path:
    folder = tmp_path / "kalman"
    for kind, name in (
        ("module", "l19"),
        ("page", "l19/premiers-pas"),
        ("exercise", "l19/gain"),
        ("choice", "l19/quiz"),
    ):
        new.write(kind, name, folder)
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
            deadline = time.monotonic() + START_SECONDS
            while time.monotonic() < deadline and process.poll() is None:
                told = re.search(r"http://127\.0\.0\.1:\d+", (tmp_path / "log.txt").read_text())
                if told:
                    break
                time.sleep(0.05)
            yield told[0] if told else pytest.fail((tmp_path / "log.txt").read_text())
        finally:
            process.terminate()
            process.wait(20)


def replace(path: Path, old: str, fresh: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, fresh), encoding="utf-8")


def test_the_first_hour_of_an_author(place: Path, address: str, browser: Any) -> None:
    page = browser.new_page(viewport={"width": 900, "height": 500})
    page.set_default_timeout(30_000)
    lesson = place / "curriculum" / "l19" / "seances" / "premiers-pas.md"
    page.goto(f"{address}/l19/lire/premiers-pas")
    foot = page.locator("#apercu")
    expect(foot).to_contain_text("rien à corriger")

    # A change is seen at once, where one was.
    page.evaluate("scrollTo({top: 260, behavior: 'instant'})")
    replace(lesson, "Une cellule s’exécute", "Cette cellule-ci s’exécute")
    expect(page.get_by_text("Cette cellule-ci s’exécute")).to_be_visible()
    page.wait_for_function("() => Math.abs(scrollY - 260) < 60")

    # What is wrong is told in the page, with its file and line.
    replace(lesson, "## Une idée", "## Une idée\n\nVoyez [](page:nulle-part).")
    expect(foot).to_contain_text("curriculum/l19/seances/premiers-pas.md:")
    expect(foot).to_contain_text("nulle-part")
    replace(lesson, "Voyez [](page:nulle-part).", "")
    expect(foot).to_contain_text("rien à corriger")

    # A known mistake, at a click: what a student would see.
    page.goto(f"{address}/l19/exercices/gain")
    foot.get_by_role("link", name=re.compile("Essayer")).click()
    expect(page.get_by_text("gain(2, 10, 0,25)")).to_be_visible()
    page.get_by_role("button", name="Essayer : erreur bouts_echanges").click()
    expect(page.get_by_role("heading", name="Le départ et l’arrivée sont échangés")).to_be_visible()
    page.wait_for_function("() => [...document.querySelectorAll('.figure img')].some((one) => one.naturalWidth > 0)")
    attempt = page.url

    # The grader's own code is read again, in a fresh interpreter: a mistake of the author's, then another solution.
    grader = place / "graders" / "l19" / "gain" / "grader.py"
    replace(grader, "points=12,", "points=11,")
    expect(foot).to_contain_text("graders/l19/gain/grader.py")
    expect(foot).to_contain_text("19")
    replace(grader, "points=11,", "points=12,")
    replace(grader, "yield 2.0, 10.0, 0.25", "yield 2.0, 10.0, 0.5")
    page.goto(f"{address}/apercu/l19/gain")
    expect(page.get_by_text("gain(2, 10, 0,5)")).to_be_visible()
    page.get_by_role("button", name="Essayer : référence").click()
    expect(page.locator(".score")).to_contain_text("20")
    assert page.url != attempt
    page.goto(f"{address}/apercu/l19/quiz")
    page.get_by_role("button", name="Essayer : chemin : deux").click()
    expect(page.get_by_role("heading", name="Le point de départ est oublié")).to_be_visible()
    page.close()


def test_what_stops_python_leaves_the_preview_standing(place: Path, address: str, browser: Any) -> None:
    page = browser.new_page()
    page.set_default_timeout(30_000)
    page.goto(f"{address}/l19")
    foot = page.locator("#apercu")
    expect(foot).to_contain_text("rien à corriger")
    grader = place / "graders" / "l19" / "gain" / "grader.py"
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


def test_a_course_that_was_written_is_checked_and_served_alone(place: Path) -> None:
    environment = {**os.environ, "BALISE_COURSES": str(place)}
    checked = subprocess.run(
        [sys.executable, "-m", "server", "check", "l19/gain", "l19/quiz"],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert "erreur bouts_echanges" in checked.stdout
