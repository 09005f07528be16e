"""What a start does before it gives its address, counted: modules and texts, since seconds are the machine's."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from server.base.files import ROOT
from server.base.settings import Settings
from server.cli.local import load_course_of_exercise
from server.course.start_cache import CACHE_FILE, ExerciseFacts, StartCache, digest_sources
from tests.support.quick import migrated, the_course

START = """
import collections, json, sys
from concurrent.futures import Future
from pathlib import Path

opened = collections.Counter()
sys.addaudithook(lambda event, args: opened.update([str(args[0])]) if event == "open" else None)

from server.cli import serve
from server.cli.configuration import read_settings
from server.base.app_services import get_service
from server.course import Course

def told(app, *_):
    modules = get_service(app, Course).modules.values()
    print(json.dumps({
        "modules": sorted(sys.modules),
        "opened": opened,
        "read": sum("outline" in vars(lesson.text) for module in modules for lesson in module.lessons),
        "graders": sum("grader" in vars(exercise) for module in modules for exercise in module.exercises),
        "exercises": {one.id: one.version for module in modules for one in module.exercises},
    }))

serve._serve_while_probing, serve.start_probing_walls = told, Future
serve.serve(read_settings(data_dir=Path(sys.argv[1])), "127.0.0.1", 0, print)
"""
#: What is slow to load, and serves only somebody who asks for it.
HEAVY = (
    "scipy", "matplotlib", "alembic", "argon2", "pygments.lexers.python", "snowballstemmer", "segno", "quickjs",
    "prometheus_client", "opentelemetry.sdk", "mcap", "copydetect", "python_calamine", "xlsxwriter", "httpx",
    "graders.l20", "reference.registration", "reference.pose_graph", "numpy.f2py",
)  # fmt: skip
#: For the digest, then to serve; the file that two kits share, for each.
MOST_READ = 3


@pytest.fixture(scope="module")
def start(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What the second start of a service on the real course says of itself."""
    folder = tmp_path_factory.mktemp("data")
    migrated(Settings(data_dir=folder)).close()
    exercises = the_course().exercises.values()
    StartCache(folder / CACHE_FILE).save_used_entries(
        digest_sources([ROOT / "curriculum"], [ROOT]), {e.id: ExerciseFacts("v", e.kit, ()) for e in exercises}
    )
    done = subprocess.run(
        [sys.executable, "-c", START, str(folder)], check=False, capture_output=True, text=True, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_nothing_heavy_is_loaded_before_the_address(start: Any) -> None:
    loaded = set(start["modules"])
    assert not [name for name in HEAVY if name in loaded or any(one.startswith(f"{name}.") for one in loaded)]


def test_texts_that_were_sound_are_neither_read_nor_graded(start: Any) -> None:
    assert (start["read"], start["graders"]) == (0, 0)
    of_the_course = {
        name: times for name, times in start["opened"].items() if name.startswith(str(ROOT / "curriculum"))
    }
    assert of_the_course, "the digest reads all of them"
    assert max(of_the_course.values()) <= MOST_READ
    assert start["exercises"].keys() == the_course().exercises.keys()


def test_who_prints_its_usage_loads_next_to_nothing() -> None:
    line = "import sys; from server.cli import main\ntry: main(['--help'])\nexcept SystemExit: print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", line], check=False, capture_output=True, text=True, cwd=ROOT)
    loaded = done.stdout.splitlines()[-1].split()
    assert {name for name in loaded if name.startswith("server")} == {
        "server", "server.base", "server.base.version", "server.cli", "server.cli.french", "server.cli.authors",
        "server.cli.options",
    }  # fmt: skip
    assert not {"numpy", "pydantic", "asyncio", "sqlalchemy"} & set(loaded)


GRADE = (
    "import json, sys; import server.cli.grade; first = [*sys.modules]; import server.cli.grade_run; "
    "print(json.dumps([first, [*sys.modules]]))"
)
#: What only reads texts, or grades exercises without code.
OF_OTHERS = {"markdown_it", "pygments", "server.text.markup.parser", "graders.core.answers"}


def test_a_sandbox_comes_up_before_what_grades_is_loaded() -> None:
    done = subprocess.run([sys.executable, "-c", GRADE], check=True, capture_output=True, text=True, cwd=ROOT)
    first, all_of_it = map(set, json.loads(done.stdout))
    assert "server.sandbox.pool" in first
    assert not {"server.course", "pydantic", "graders.core.code", "graders.core.contract.verdict"} & first
    assert "graders.core.code.grading" in all_of_it
    assert not OF_OTHERS & all_of_it


def test_what_an_exercise_s_files_import_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = load_course_of_exercise("l20/poses").version_of_exercise("l20/poses")
    read = Mock(side_effect=AssertionError("read again"))
    monkeypatch.setattr("server.course.closure._imported_modules", read)
    assert load_course_of_exercise("l20/poses").version_of_exercise("l20/poses") == first
    next(tmp_path.rglob("imports.json")).unlink()
    with pytest.raises(AssertionError, match="read again"):
        load_course_of_exercise("l20/poses")


def test_an_exercise_is_read_where_nothing_may_be_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert "l20/poses" in load_course_of_exercise("l20/poses").exercises
