"""The drawings of the texts: announced without being run, drawn when they are looked at, in both themes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from graders import courses
from graders.plotting import THEMES, palette
from server.base.files import ROOT
from server.course import Course
from server.course.drawings import describe_verdict_figures
from server.figures import drawing_requests, lessons
from tests.support.quick import the_course
from tests.support.small_course import CourseFolder
from tests.support.texts_on_disk import FIGURES, problems

PATH = "curriculum/m9/figures/dessins.py"
BAD = {
    "no table": ("x = 1\n", 1, "dictionnaire écrit en toutes lettres"),
    "computed table": ("\nFIGURES = dict()\n", 2, "dictionnaire écrit en toutes lettres"),
    "no text": ('def f(): ...\nFIGURES = {\n    "a": (f, ""),\n}\n', 3, "figure mal annoncée"),
    "computed text": ('FIGURES = {"a": (f, f"{1}")}\n', 1, "figure mal annoncée"),
    "no function": ('FIGURES = {"a": "Un texte."}\n', 1, "figure mal annoncée"),
    "bad size": ('FIGURES = {"a": (f, "Un texte.", 3)}\n', 1, "taille d’une figure"),
    "bad name": ('FIGURES = {"Été": (f, "Un texte.")}\n', 1, "nom de figure"),
    "given twice": ('FIGURES = {"a": (f, "Un texte."), "a": (f, "Un texte.")}\n', 1, "déjà dessinée"),
    "does not compile": ("x = (\n", 1, "ne se compile pas"),
}


@pytest.mark.parametrize(("content", "line", "message"), BAD.values(), ids=BAD.keys())
def test_a_badly_announced_figure_is_told_with_its_line(
    course_folder: CourseFolder, content: str, line: int, message: str
) -> None:
    path = course_folder.write(PATH, content)
    (problem,) = problems(course_folder, render=False)
    assert (problem.path, problem.line) == (path, line)
    assert message in problem.message


def test_what_is_announced_is_known_without_running_it(course_folder: CourseFolder) -> None:
    course_folder.write(PATH, FIGURES + "\nraise SystemExit\n")
    course_folder.write("curriculum/m9/figures/_aide.py", "raise SystemExit\n")
    drawings = course_folder.load(render=False).modules["m9"].drawings
    assert {name: (one.alt, one.size) for name, one in drawings.items()} == {
        "trace": ("Une ligne qui monte & l'axe.", (6.4, 4.0)),
        "bande": ("Une bande.", (6.4, 2.0)),
    }


@pytest.mark.parametrize(
    ("source", "described"),
    [
        ('FIGURES = {"way": (draw, "Le chemin, " "en bleu.")}\n', {"way": "Le chemin, en bleu."}),
        ('FIGURES = {"way": draw}\n', {}),
        ('FIGURES = {"way": (draw, f"{1}")}\n', {}),
        ("from graders.core.declared.figure_data import FEWEST\nFIGURES = {FEWEST: (draw, 'Le chemin.')}\n", {}),
        ("from graders.m9.nowhere import WAY\nFIGURES = {WAY: (draw, 'Le chemin.')}\n", {}),
        ("from .pictures import WAY\nFIGURES = {WAY: (draw, 'Le chemin.')}\n", {}),
        ("x = (\n", {}),
    ],
    ids=["with words", "bare function", "computed words", "no text as a key", "no module", "relative", "no Python"],
)
def test_a_verdicts_figure_that_says_nothing_keeps_no_page_from_being_served(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, described: dict[str, str]
) -> None:
    path = tmp_path / "m9" / "a" / "figures.py"
    path.parent.mkdir(parents=True)
    path.write_text(source, encoding="utf-8")
    monkeypatch.setattr(courses, "room_folders", lambda _room: [tmp_path])
    describe_verdict_figures.cache_clear()
    shown = describe_verdict_figures("m9/a")
    describe_verdict_figures.cache_clear()
    assert {kind: words for kind, words in shown.items() if not kind.startswith("declared_")} == described


def catalogue_of(course_folder: CourseFolder, text: str) -> Course:
    course_folder.write(PATH, text)
    return course_folder.load(render=False)


def test_a_drawing_is_the_same_each_time_and_not_in_the_other_theme(course_folder: CourseFolder) -> None:
    course = catalogue_of(course_folder, FIGURES)
    drawing = course.modules["m9"].drawings["trace"]
    light = lessons.draw_lesson_figure(drawing, "light", "svg").picture
    assert light.startswith(b"<?xml")
    assert lessons.draw_lesson_figure(drawing, "light", "svg").picture == light
    dark = lessons.draw_lesson_figure(drawing, "dark", "svg").picture
    assert palette("dark").paper.encode() in dark
    assert palette("dark").paper.encode() not in light


def test_another_text_makes_another_figure_and_the_same_text_the_same(course_folder: CourseFolder) -> None:
    """Under the name of a picture, what is kept of an earlier start is found, or is not."""
    drawing = catalogue_of(course_folder, FIGURES).modules["m9"].drawings["trace"]

    def key(theme: drawing_requests.Theme = "light") -> str:
        drawing_requests.module_drawings_digest.cache_clear()
        return drawing_requests.build_lesson_figure_request(drawing, theme).key

    first = key()
    assert key("dark") != first
    course_folder.write("curriculum/m9/figures/_aide.py", "x = 1\n")
    second = key()
    course_folder.write("curriculum/m9/kit/m9.py", "def configurer():\n    return {1: 1}\n")
    assert len({first, second, key()}) == 3
    (course_folder.root / "curriculum/m9/figures/_aide.py").unlink()
    course_folder.write("curriculum/m9/kit/m9.py", "def configurer():\n    return {}\n")
    assert key() == first


def test_check_tells_what_does_not_draw_or_changes_size(course_folder: CourseFolder) -> None:
    course = catalogue_of(
        course_folder,
        "def panne(figure, palette):\n    1 / 0\n"
        "def grand(figure, palette):\n    figure.set_size_inches(6.4, 9)\n"
        "def juste(figure, palette):\n    figure.subplots()\n"
        'FIGURES = {\n    "panne": (panne, "A"),\n    "grand": (grand, "A"),\n    "juste": (juste, "A"),\n}\n',
    )
    found = [(one.line, one.message) for one in lessons.find_drawing_faults(course)]
    assert [line for line, _ in found] == [8, 9]
    assert "« panne » ne se dessine pas (ZeroDivisionError" in found[0][1]
    assert '"grand": (grand, "…", (6.4, 9))' in found[1][1]


def test_what_fails_on_dark_paper_alone_is_told(course_folder: CourseFolder) -> None:
    course = catalogue_of(
        course_folder,
        "from graders.plotting import palette as of\n"
        "def nuit(figure, palette):\n    {of('light'): 1}[palette]\n"
        "def ombre(figure, palette):\n"
        "    figure.set_size_inches((6.4, 3) if palette == of('light') else (6.4, 9))\n"
        'FIGURES = {\n    "nuit": (nuit, "A"),\n    "ombre": (ombre, "A", (6.4, 3)),\n}\n',
    )
    night, shade = [one.message for one in lessons.find_drawing_faults(course)]
    assert "KeyError" in night
    assert "(6.4, 9)" in shade


@pytest.mark.slow
def test_the_drawings_of_the_course_are_drawn_at_their_size() -> None:
    assert [str(one) for one in lessons.find_drawing_faults(the_course())] == []


def test_some_drawings_of_the_course_are_drawn_at_their_size() -> None:
    drawings = the_course().modules["l20"].drawings
    for name in sorted(drawings)[::4]:
        assert (
            lessons.describe_size_fault(drawings[name], lessons.draw_lesson_figure(drawings[name], "light", "svg").size)
            == ""
        ), name


@pytest.mark.parametrize("theme", THEMES)
def test_colours_can_be_read_on_their_paper(theme: str) -> None:
    colours = palette(theme)
    for name in ("ink", "truth", "estimate", "measure", "alert", "second"):
        assert contrast(getattr(colours, name), colours.paper) >= 4.5, name
    assert colours.ramp(0.0)[:3] == pytest.approx(channels(colours.paper), abs=1e-6)


def channels(colour: str) -> tuple[float, ...]:
    return tuple(int(colour[start : start + 2], 16) / 255 for start in (1, 3, 5))


def contrast(first: str, second: str) -> float:
    """The contrast of WCAG 2."""
    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


def luminance(colour: str) -> float:
    linear = [one / 12.92 if one <= 0.04045 else ((one + 0.055) / 1.055) ** 2.4 for one in channels(colour)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_a_writer_can_look_at_a_drawing(tmp_path: Path) -> None:
    name = next(iter(the_course().modules["l20"].drawings))
    out = tmp_path / "dessin.png"
    command = [sys.executable, "-m", "server.reading.preview", "--module", "l20", name, str(out), "--theme", "dark"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert out.read_bytes().startswith(b"\x89PNG")
