"""Texts as PDF files: what the printer is given, what one is told without a browser, and that it prints."""

from __future__ import annotations

import re
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import pytest

from server.cli import CommandError, export
from server.course import Course
from server.offline import paper, site
from server.reading.downloads import DownloadArchives
from tests.support.quick import the_course

SLUGS = ("epreuve-corrige", "recherche")
PICTURE = b"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1 1'/>"


def pictures(course: Course) -> site.Pictures:
    return dict.fromkeys(site.list_needed_pictures(course.modules["l20"]), PICTURE)


def test_the_printer_gets_all_pictures_at_once_and_no_way_to_other_files() -> None:
    page = (
        '<a class="x" href="slam.html#un">S</a> <a href="#ici">I</a> <a href="https://a.fr">A</a> <img loading="lazy">'
    )
    assert (
        paper.prepare_page_for_print(page)
        == '<a class="x">S</a> <a href="#ici">I</a> <a href="https://a.fr">A</a> <img>'
    )


def test_on_paper_a_module_has_the_answers_and_no_script() -> None:
    course = the_course()
    module = course.modules["l20"]
    lessons = tuple(one for one in module.lessons if one.solution)
    only = replace(module, lessons=lessons, exercises=(), glossary={})
    made = site.OfflineSite(course, only, {}, DownloadArchives(course), on_paper=True)
    (copy,) = (page for place, page in made._render_pages() if place == "lire/epreuve-corrige.html")
    assert "En ligne seulement" not in copy
    assert "6{,}368" in copy
    assert "<script" not in copy


def test_an_archive_has_nothing_of_what_the_answers_of_a_paper_show() -> None:
    course = the_course()
    module = course.modules["l20"]
    drawn = next(one for one in module.lessons if one.figures and one.replays)
    copy = replace(drawn, solution=True)
    only = replace(module, lessons=(copy,), exercises=(), glossary={}, files={})
    closed, printed = (
        {
            place
            for _, place in site.OfflineSite(
                course, only, pictures(course), DownloadArchives(course), on_paper=paper
            )._iter_addresses_and_paths()
        }
        for paper in (False, True)
    )
    assert not [place for place in closed if place.startswith(("figures/", "rejeux/", "manipulations/"))]
    assert {f"figures/{name}-light.svg" for name in drawn.figures} <= printed


def test_without_a_browser_one_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(CommandError, match="apt install chromium"):
        export.run(Namespace(module="l20", file=None, pdf=tmp_path))
    with pytest.raises(CommandError, match="dites ce qu’il faut écrire"):
        export.run(Namespace(module="l20", file=None, pdf=None))


@pytest.mark.parametrize("script", ["exit 3", "echo 'pas d’écran' >&2; exit 0"], ids=["fails", "writes nothing"])
def test_a_browser_that_prints_nothing_is_told(tmp_path: Path, script: str) -> None:
    command = tmp_path / "chromium"
    command.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    command.chmod(0o755)
    with pytest.raises(paper.PrintError, match="une : le navigateur a répondu"):
        paper._print_page_to_pdf(str(command), tmp_path / "une.html", tmp_path / "une.pdf")


@pytest.mark.slow
@pytest.mark.skipif(paper.find_chromium() is None, reason="no Chromium on this machine")
def test_pages_are_printed(tmp_path: Path) -> None:
    course = the_course()
    counted: list[int] = []
    made = paper.print_module_pdfs(
        course,
        course.modules["l20"],
        pictures(course),
        tmp_path / "pdf",
        command=str(paper.find_chromium()),
        slugs=SLUGS,
        advance=lambda: counted.append(1),
    )
    assert sorted(path.stem for path in made) == sorted(SLUGS)
    assert len(counted) == len(SLUGS)
    for path in made:
        content = path.read_bytes()
        assert content.startswith(b"%PDF-")
        assert len(re.findall(rb"/Type\s*/Page\b", content)) > 1
        assert b"file:///" not in content, "no way into the folder that was printed from"
