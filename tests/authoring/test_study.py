"""What classes' attempts teach: failures alike that have no name, how often, in a program as small as can be."""

from __future__ import annotations

import shutil
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest

from graders.core.code.folder import read_misconceptions
from graders.core.code.grading import CodeGrader
from graders.core.contract.local import LOCAL
from server.authoring import shapes, study
from server.base.settings import Settings
from server.cli import main
from server.cli import study as command
from server.course import toml_file
from server.database import Database
from server.identity.models import Role
from tests.support.behaviour import DIFFERENCE, SUM, SUM_AGAIN, ask_all, failed_verdict, groups, sent
from tests.support.classes import new_class, seat
from tests.support.quick import the_course
from tests.support.service import EXERCISE, new_account

WORDY = """
# Ada Lovelace
import numpy as np
def composer(a, b):
    "Par Ada."
    print("Ada")
    unused = 3
    chez = open if a is b else "/home/byron/"
    if unused:
        c = a + b
    else:
        c = a
    return c
"""


SAID = "rien de ce qui échoue n’est sans nom"


class InThisProcess:
    """Starts programs without walls: these are ours."""

    def program_starter(self, exercise: str, policy: object) -> object:
        return LOCAL


def test_groups_that_nothing_names_come_with_their_frequency(sqlite: Database, settings: Settings) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher, "Mme Martin"))
    ada, bob = (seat(sqlite, made, new_account(sqlite, name=name)) for name in ("Ada Lovelace", "Bob"))
    first = sent(sqlite, ada, SUM)
    sent(sqlite, bob, SUM_AGAIN)
    sent(sqlite, ada, DIFFERENCE)
    named = sent(sqlite, bob, DIFFERENCE + "\n# encore", failed_verdict(named="rotation_oubliee"))
    assert ask_all(sqlite, settings) == 4
    group = groups(sqlite)
    with sqlite.read() as db:
        found = study.load_unexplained_groups(db, EXERCISE, 10)
        assert study.load_unexplained_groups(db, EXERCISE, 1) == found[:1]
        assert study.load_unexplained_groups(db, "l20/lidar", 10) == []
    counted = [(one.group_id, one.attempts, one.students) for one in found]
    assert counted == [(group[first], 2, 2), (group[named], 1, 1)], "what a misconception names is not counted"
    assert found[0].source in {SUM.encode(), SUM_AGAIN.encode()}
    assert study.describe_counterexample(found[0])[1].startswith("attendu")


def test_a_program_is_shown_without_its_author_and_what_it_does_not_need(sqlite: Database, settings: Settings) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher, "Mme Martin"))
    ada = seat(sqlite, made, new_account(sqlite, name="Ada Lovelace"), family_name="Byron", given_name="Augusta")
    rest = "\ndef inverse(a):\n    return [0.0, 0.0, 0.0]\n\ndef relatif(a, b):\n    return [0.0, 0.0, 0.0]\n"
    sent(sqlite, ada, WORDY + rest)
    ask_all(sqlite, settings)
    exercise = the_course().exercises[EXERCISE]
    with sqlite.read() as db:
        (found,) = study.load_unexplained_groups(db, EXERCISE, 10)
    assert {"Ada", "Lovelace", "Augusta", "Byron"} <= set(found.names), "as the lists of classes have them too"
    assert "byron" not in study.minimise_program(found, exercise, None)
    program = study.minimise_program(found, exercise, InThisProcess())  # type: ignore[arg-type]
    assert "Ada" not in program
    assert "c = a + b" in program
    assert [word for word in ("import", "unused", "print", "else") if word in program] == [], program
    assert "def relatif" in program, "what is wrong there too is behaviour"


def test_shrinking_stops_at_what_it_may_cost() -> None:
    asked: list[str] = []
    lines = "".join(f"x{number} = {number}\n" for number in range(40))
    kept = study.shrink_program(lines, lambda text: not asked.append(text) and "x7 = 7" in text, tries=500)
    assert kept == "x7 = 7\n"
    asked.clear()
    study.shrink_program(lines, lambda text: not asked.append(text), tries=5)
    assert len(asked) == 5


def test_the_command_tells_the_groups_and_refuses_one_that_is_not_there(
    sqlite: Database, settings: Settings, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("BALISE_DATABASE_URL", settings.sqlalchemy_url)
    monkeypatch.setattr(command, "load_unrendered_course", the_course)
    monkeypatch.setattr(command, "start_probing_walls", lambda **_: None)
    monkeypatch.setattr(command, "local_grader", lambda *_: nullcontext(InThisProcess()))
    assert main(["study", EXERCISE]) == 0
    assert SAID in capsys.readouterr().out
    made = new_class(sqlite, new_account(sqlite, Role.teacher, "Mme Martin"))
    sent(sqlite, seat(sqlite, made, new_account(sqlite, name="Ada")), SUM)
    ask_all(sqlite, settings)
    (name,) = groups(sqlite).values()
    assert main(["study", EXERCISE, "--most", "3"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(f"{name} : 1 essai")
    assert "    def composer" in told
    assert main(["study", EXERCISE, "--write", "nobody"]) == 2
    assert f"aucun groupe « nobody ». Groupes : {name}." in capsys.readouterr().err
    assert main(["study", "l20/nothing"]) == 2
    monkeypatch.setenv("BALISE_DATABASE_URL", "sqlite:////nowhere/at/all.sqlite3")
    assert main(["study", EXERCISE]) == 2
    assert "il n’y a pas de base de données" in capsys.readouterr().err


def test_a_group_becomes_a_misconception_to_word(tmp_path: Path) -> None:
    folder = tmp_path / "poses"
    exercise = the_course().exercises[EXERCISE]
    assert isinstance(exercise.grader, CodeGrader)
    shutil.copytree(exercise.grader.folder, folder, ignore=shutil.ignore_patterns("__pycache__", "specimens"))
    grader = replace(exercise.grader, folder=folder)
    here = replace(exercise, make=lambda: grader)
    found = study.UnexplainedGroup("ab12", 4, 3, ("composer",), None, exercise.version, None, b"", ())
    catalogue, file = study.write_misconception(found, here, "def composer(a, b):\n    return a\n")
    shape = toml_file.read_toml(catalogue, shapes.MisconceptionsFile)
    assert shape.misconception[-1].id == file.stem == "erreur_ab12"
    assert study.PLACEHOLDER in shape.misconception[-1].title
    *_, last = read_misconceptions(folder, "")
    assert (last.id, last.functions) == ("erreur_ab12", ("composer",))
    names: dict[str, object] = {}
    exec(compile(file.read_bytes(), "<written>", "exec"), names)
    assert "composer" not in names, "unread, it would run beside what makes verdicts"
    exec(compile(file.read_text(encoding="utf-8").replace("False", "True", 1), "<read>", "exec"), names)
    assert "composer" in names
    assert "4 essais, 3 élèves" in catalogue.read_text(encoding="utf-8")
    with pytest.raises(study.MisconceptionWriteError):
        study.write_misconception(found, the_course().exercises["l20/verification"], "")
