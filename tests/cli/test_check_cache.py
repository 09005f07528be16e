"""What `balise check` remembers: what was in order is left alone until anything that it was found from has changed."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from graders.core.contract.local import LOCAL
from graders.courses import COURSES
from graders.discovery import discover
from server.authoring import new
from server.base.files import default_cache_dir
from server.cli import check, check_cache
from server.course import load_course
from server.course.closure import ImportGraph
from server.course.service import load_course as load_whole
from tests.support.outside import taken_in

Run = Callable[..., tuple[int, list[str]]]
GRADERS = "graders/l21/gain"
EXERCISE = "curriculum/l21/exercices/gain"


class Grader:
    """Grades in this process what is ours."""

    def __init__(self, course: Any) -> None:
        self._course = course

    def grade(self, exercise: str, source: bytes, seed: int, **_: Any) -> Any:
        return self._course.exercises[exercise].grader.grade(source, LOCAL, seed=seed, version="")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.delenv("CI", raising=False)
    folder = tmp_path / "commande"
    for kind, name in (("module", "l21"), ("exercise", "l21/gain")):
        new.write_skeleton(kind, name, folder)
    with taken_in(folder):
        yield folder


@pytest.fixture
def run(place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """The exit status and the lines of a check of this course, whose programs run in this process."""

    def in_order(course: Any, work: Any, jobs: Sequence[Any], *_: Any) -> Iterator[Any]:
        return (work(Grader(course), job) for job in jobs)

    monkeypatch.setattr(check.parallel, "run_in_order", in_order)
    monkeypatch.setattr(check, "start_probing_walls", lambda **_: None)
    monkeypatch.setattr(check, "require_safe_sandbox", lambda _: None)
    found = discover(rooms=[place / "graders"])
    monkeypatch.setattr(check, "load_course", partial(load_whole, place / "curriculum", discovery=found))

    def run(*exercises: str, fresh: bool = False, remember: bool = False) -> tuple[int, list[str]]:
        capsys.readouterr()
        code = check._check_courses(Namespace(exercises=list(exercises), fresh=fresh, remember=remember, course=None))
        return code, capsys.readouterr().out.splitlines()

    return run


def tried(lines: list[str]) -> int:
    return sum(line.startswith(("✓ l21/gain", "✗ l21/gain")) and "inchangé" not in line for line in lines)


def test_what_is_unchanged_is_not_tried_again(run: Run, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code, lines = run("l21/gain")
    assert (code, tried(lines)) == (0, 4)
    code, lines = run("l21/gain")
    assert (code, tried(lines)) == (0, 0)
    assert "inchangé depuis le 20" in lines[0]
    assert tried(run("l21/gain", fresh=True)[1]) == 4
    monkeypatch.setenv("CI", "true")
    assert tried(run("l21/gain")[1]) == 4, "continuous integration tries everything"
    assert tried(run("l21/gain", remember=True)[1]) == 0, "unless it is asked not to"
    monkeypatch.delenv("CI")
    (default_cache_dir() / check_cache.FILE).write_text("{damaged")
    assert tried(run("l21/gain")[1]) == 4
    assert tried(run("l21/gain")[1]) == 0
    (place / GRADERS / "specimens" / "ok" / "faux.py").write_text("def gain(a, b, t):\n    return a\n")
    code, lines = run("l21/gain")
    assert (code, tried(lines)) == (1, 5)
    assert run("l21/gain")[0] == 1, "what is at fault is tried each time"


def test_any_file_that_it_was_found_from_counts(place: Path) -> None:
    def digest() -> str:
        course = load_course(place / "curriculum", code=place, render=False)
        return check_cache.exercise_digest(course.exercises["l21/gain"], ImportGraph(*COURSES.folders))

    before = digest()
    assert digest() == before
    changed = [
        f"{GRADERS}/solution.py", f"{GRADERS}/misconceptions/bouts_echanges.py", f"{GRADERS}/specimens/ok/autrement.py",
        f"{GRADERS}/figures.py", f"{EXERCISE}/starter.py", f"{EXERCISE}/enonce.md",
    ]  # fmt: skip
    seen = {before}
    for name in changed:
        path = place / name
        path.write_text(path.read_text(encoding="utf-8") + "\n", encoding="utf-8")
        seen.add(digest())
    assert len(seen) == len(changed) + 1


def test_what_surrounds_the_course_counts_too(monkeypatch: pytest.MonkeyPatch) -> None:
    check_cache.environment_digest.cache_clear()
    before = check_cache.environment_digest()
    for target, value in (("version", lambda _: "99"), ("CHECKER_SOURCES", ("server/base",))):
        with monkeypatch.context() as one:
            one.setattr(check_cache, target, value)
            check_cache.environment_digest.cache_clear()
            assert check_cache.environment_digest() != before
    check_cache.environment_digest.cache_clear()
    assert check_cache.environment_digest() == before
