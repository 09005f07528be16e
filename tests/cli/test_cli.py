"""The command line, without a server."""

from __future__ import annotations

import json
import subprocess
import sys
from argparse import Namespace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import httpx
import pytest

from graders.core.contract.bounds import VERDICT_BYTES
from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.cli import check, main, report
from server.cli.files import read_text
from server.course import Course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox, WallReport, WallStatus
from tests.support.live import balise, environment
from tests.support.service import EXERCISE, fake_verdict


@pytest.fixture
def right(tmp_path: Path, course: Course) -> Path:
    path = tmp_path / "right.py"
    path.write_text(course.exercises[EXERCISE].solution)
    return path


@pytest.fixture
def walls_that_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a probe, which takes longer than grading; the command in a process of its own has the real one."""
    standing = WallReport("seccomp", WallStatus.STANDING, "", required=True)
    monkeypatch.setattr("server.cli.sandboxes.probe", lambda **_: [standing])


@pytest.fixture(autouse=True)
def _course_that_is_read_once(monkeypatch: pytest.MonkeyPatch, course: Course) -> None:
    """A command in a process of its own reads it for itself."""
    monkeypatch.setattr("server.cli.local.load_course", lambda **_: course)


def verdict_of(text: str) -> dict[str, Any]:
    verdict: dict[str, Any] = json.loads(text)
    return verdict


def test_a_file_is_graded_in_another_process_without_a_trace(right: Path, tmp_path: Path) -> None:
    done = balise("grade", EXERCISE, str(right), "--json", "--seed", "42", XDG_DATA_HOME=str(tmp_path / "home"))
    assert (done.returncode, done.stderr) == (0, "")
    verdict = verdict_of(done.stdout)
    assert (verdict["outcome"], verdict["points"], verdict["seed"]) == ("ok", 20.0, 42)
    assert not (tmp_path / "home").exists()


@pytest.mark.usefixtures("walls_that_stand")
def test_a_wrong_file_is_explained_in_french(tmp_path: Path, course: Course, capsys: Any) -> None:
    misconception = course.exercises[EXERCISE].grader.misconceptions[0]
    wrong = tmp_path / "wrong.py"
    wrong.write_text(misconception.source)
    assert main(["grade", EXERCISE, str(wrong)]) == 1
    told = capsys.readouterr().out
    for part in ("/20", "✗", "✓", "attendu :", "obtenu :", f"Diagnostic : {misconception.title}"):
        assert part in told


def test_what_cannot_be_graded_has_its_own_status(
    right: Path, tmp_path: Path, course: Course, monkeypatch: Any, capsys: Any
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr("server.cli.sandboxes.Sandbox.warm", lambda *_: None)  # no program is run
    stands = WallReport("seccomp", WallStatus.STANDING, "", required=True)
    monkeypatch.setattr("server.cli.sandboxes.probe", lambda **_: [stands])
    assert main(["grade", "l20/inconnu", str(right)]) == 2
    assert "n’existe pas" in capsys.readouterr().err
    assert main(["grade", "../x", str(right)]) == 2
    assert "n’existe pas" in capsys.readouterr().err
    assert main(["grade", EXERCISE, str(tmp_path / "absent.py")]) == 2
    assert main(["grade", EXERCISE, str(tmp_path)]) == 2
    assert "dossier" in capsys.readouterr().err
    hole = WallReport("seccomp", WallStatus.MISSING, "rien n’a été refusé", required=True)
    monkeypatch.setattr("server.cli.sandboxes.probe", lambda **_: [hole])
    assert main(["grade", EXERCISE, str(right)]) == 2
    assert "rien n’a été refusé" in capsys.readouterr().err
    monkeypatch.setattr("server.cli.serve.load_course", lambda **_: course)
    assert main(["serve", "--port", "0", "--data", str(tmp_path / "data")]) == 2
    assert "rien n’a été refusé" in capsys.readouterr().err
    monkeypatch.setattr("server.cli.doctor.probe", lambda **_: [hole])
    assert main(["doctor"]) == 1
    assert "✗ seccomp" in capsys.readouterr().out


WRONG_USAGE = {
    (): "il manque COMMANDE",
    ("zut",): "COMMANDE : « zut » n’existe pas. Au choix : "
    "'serve', 'demo', 'grade', 'check', 'new', 'schema', 'study', 'preview', 'doctor', 'submit', 'login', 'export', "
    "'worker', 'top', 'backup', 'restore', 'move', 'admin'",
    ("admin",): "il manque ACTION",
    ("grade",): "il manque EXERCISE",
    ("doctor", "--vite"): "argument inconnu : --vite",
    ("serve", "--port"): "--port : il manque sa valeur",
    ("serve", "--port", "70000"): "--port : le port doit être un entier de 0 à 65535",
    ("grade", "a", "b", "--seed", "-1"): "--seed : la graine doit être un entier de 0 à 9007199254740991",
    ("grade", "a", "b", "--json=oui"): "--json : ne prend pas de valeur (oui)",
}


@pytest.mark.parametrize(("arguments", "reason"), WRONG_USAGE.items())
def test_wrong_usage_is_refused_in_french(arguments: tuple[str, ...], reason: str, capsys: Any) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    usage, last = capsys.readouterr().err.replace("\u00a0", " ").replace("\u202f", " ").rstrip("\n").rsplit("\n", 1)
    assert usage.startswith("utilisation : balise")
    assert last.startswith("balise")
    assert last.split(" : ", 1)[1] == reason


@pytest.mark.parametrize("command", [(), ("serve",), ("grade",), ("check",), ("submit",)])
def test_help_is_in_french(command: tuple[str, ...], capsys: Any) -> None:
    with pytest.raises(SystemExit) as stopped:
        main([*command, "--help"])
    assert stopped.value.code == 0
    told = capsys.readouterr().out
    assert told.startswith("utilisation")
    assert "affiche cette aide" in told
    assert not {"usage", "show", "positional", "exit"} & set(told.replace(":", " ").split())


def test_a_remote_worker_needs_a_database(monkeypatch: Any, capsys: Any) -> None:
    monkeypatch.delenv("BALISE_DATABASE_URL", raising=False)
    assert main(["worker"]) == 2
    assert "BALISE_DATABASE_URL" in capsys.readouterr().err


def test_help_loads_nothing_slow() -> None:
    code = "import sys, server.cli as c; c._build_parser().format_help(); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), check=True)
    assert not {"numpy", "fastapi", "sqlalchemy", "pydantic", "httpx"} & set(done.stdout.split())


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"\xef\xbb\xbfx = 1\r\n", "x = 1\r\n"),
        ("# coding: latin-1\né = 1\n".encode("latin-1"), "# coding: latin-1\né = 1\n"),
        ("é = 1\n".encode(), "é = 1\n"),
    ],
)
def test_files_are_read_as_python_reads_them(tmp_path: Path, content: bytes, text: str) -> None:
    path = tmp_path / "f.py"
    path.write_bytes(content)
    assert read_text(str(path)) == text


def test_a_program_s_output_cannot_drive_the_terminal() -> None:
    assert report.replace_control_characters("a\x1b[2Jb\u202ec\u00a0d") == "a·[2Jb·c\u00a0d"


@pytest.mark.parametrize(("value", "text"), [(17.5, "17,5"), (20.0, "20"), (0, "0"), (10 / 3, "3,33")])
def test_numbers_are_french(value: float, text: str) -> None:
    assert report.format_number(value) == text


class Shifted:
    """A grader that grades something else than what it is given: what `check` must notice."""

    def __init__(self, grader: SandboxGrader, source: str) -> None:
        self.grader, self.source = grader, source.encode()

    def grade(self, exercise: str, source: bytes, seed: int, **options: Any) -> Any:
        return self.grader.grade(exercise, self.source, seed, **options)


def test_check_tries_all_that_is_known_of_an_exercise_and_notices_what_is_wrong(
    course: Course, course_sandbox: Sandbox
) -> None:
    """That all of it is well is the work of `tests/content/curriculum/test_course.py`."""
    exercise = course.exercises[EXERCISE]
    known = [case.subject for case in check.list_cases(exercise)]
    assert len(known) == 2 + len(exercise.grader.misconceptions) + len(list(exercise.grader.specimens()))
    grader = SandboxGrader(course, course_sandbox)
    good, all_right, all_wrong = (
        {
            case.subject: check.examine_case(tried, exercise, case, 2026).fault
            for case in islice(check.list_cases(exercise), 3)
        }  # type: ignore[arg-type]
        for tried in (grader, Shifted(grader, exercise.solution), Shifted(grader, "x = 1\n"))
    )
    assert good == dict.fromkeys(known[:3], "")
    first = f"erreur {exercise.grader.misconceptions[0].id}"
    assert all_right["référence"] == ""
    assert "obtient tous les points" in all_right["fichier de départ"]
    assert "obtient tous les points" in all_right[first]
    assert "missing_function obtenu" in all_wrong["référence"]
    assert "diagnostic obtenu : aucun" in all_wrong[first]


def test_check_notices_a_film_that_cannot_be_played() -> None:
    verdict = fake_verdict("x = 1", 1)
    film = {"kind": "localisation", "start": [1, 1], "commands": [], "cells": [], "beliefs": []}
    broken = Judgement(verdict, {}, {"b": {**film, "kind": "rien"}})
    assert "le film de b ne se rejoue pas (KeyError" in check.unreplayable_films("l20/predire2d", broken)
    walk = {**film, "commands": [[1, 0]], "cells": [[1, 2]]}
    assert check.unreplayable_films("l20/predire2d", Judgement(verdict, {}, {"b": walk})) == ""


ANSWERED = "l20/calcul_odometrie"


def test_answers_are_graded_from_a_file_without_any_wall(tmp_path: Path, course: Course, capsys: Any) -> None:
    grader = course.exercises[ANSWERED].answers
    assert grader is not None
    file = tmp_path / "réponses.json"
    file.write_text(json.dumps(grader.right_answers(12)))
    assert main(["grade", ANSWERED, str(file), "--seed", "12", "--json"]) == 0
    assert verdict_of(capsys.readouterr().out)["points"] == 20
    assert main(["grade", ANSWERED, str(file), "--seed", "13"]) == 1
    assert "✗ Chemin du robot" in capsys.readouterr().out


def test_questions_are_told_for_a_seed_and_only_where_there_are_some(capsys: Any) -> None:
    assert main(["grade", "l20/verification", "--questions", "--seed", "3"]) == 0
    told = capsys.readouterr().out
    assert "graine 3" in told
    assert "    d) " in told
    assert '"fermeture": ["a", "b"]' in told
    assert "Une seule réponse est bonne." in told.split("amcl :")[1].split("    a) ")[0]
    assert "Une ou plusieurs réponses sont bonnes." in told.split("fermeture :")[1].split("    a) ")[0]
    assert main(["grade", ANSWERED, "--questions", "--seed", "3"]) == 0
    assert "= 0," in capsys.readouterr().out
    assert main(["grade", EXERCISE, "--questions"]) == 2
    assert main(["grade", EXERCISE]) == 2
    assert "il manque le fichier" in capsys.readouterr().err


@pytest.mark.usefixtures("walls_that_stand")
def test_check_refuses_an_unknown_exercise(course: Course, monkeypatch: Any) -> None:
    monkeypatch.setattr(check, "load_course", lambda **_: course)
    assert main(["check", "--fresh", "l20/inconnu"]) == 2


@pytest.mark.usefixtures("walls_that_stand")
def test_a_broken_exercise_is_a_failure_of_check(monkeypatch: Any, tmp_path: Path, capsys: Any) -> None:
    from server.cli import check as command
    from server.course import Problem

    broken = Course({}, (Problem(tmp_path / "exercise.toml", 3, "titre manquant"),))
    monkeypatch.setattr(command, "load_course", lambda **_: broken)
    assert (
        command.run(Namespace(exercises=[], fairness=None, mutants=False, fresh=True, remember=False, course=None)) == 1
    )
    assert "exercise.toml:3: titre manquant" in capsys.readouterr().out


def test_a_token_that_is_none_is_said_in_a_sentence(capsys: Any, tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text("x = 1")
    assert main(["submit", EXERCISE, str(file), "--server", "http://127.0.0.1:1", "--token", "jeton…"]) == 2
    assert "jeton" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("verdict", "place"), [({}, "« exercise »"), ({"exercise": 3}, "« exercise »"), (None, "lire."), ("ok", "lire.")]
)
def test_a_server_that_answers_something_else_than_a_verdict_is_told_in_a_sentence(
    monkeypatch: Any, tmp_path: Path, capsys: Any, verdict: Any, place: str
) -> None:
    def answer(request: httpx.Request) -> httpx.Response:
        if request.method == "POST":
            return httpx.Response(202, json={"url": "/api/v1/submissions/1"})
        said = (
            {"status": "queued", "position": 1, "notice": "plus rien n’est corrigé"},
            {"status": "done", "verdict": verdict},
        )
        return httpx.Response(200, text="".join(f"data: {json.dumps(one)}\n\n" for one in said))

    client = partial(httpx.Client, transport=httpx.MockTransport(answer))
    monkeypatch.setattr("server.cli.remote.httpx.Client", client)
    file = tmp_path / "a.py"
    file.write_text("x = 1")
    assert main(["submit", EXERCISE, str(file), "--server", "http://serveur", "--token", "jeton"]) == 2
    told = capsys.readouterr().err
    assert "n’est pas un verdict" in told
    assert place in told
    assert "plus rien n’est corrigé\n" in told


@pytest.mark.parametrize("at_once", [True, False])
def test_what_a_test_holds_back_is_received_and_not_waited_for(
    monkeypatch: Any, tmp_path: Path, capsys: Any, at_once: bool
) -> None:
    asked = []

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(request.method)
        held = {"url": "/api/v1/submissions/1", "status": "running", "held": at_once or request.method == "GET"}
        text = json.dumps({**held, "verdict": None})
        return httpx.Response(202, text=text if request.method == "POST" else f"data: {text}\n\n")

    monkeypatch.setattr("server.cli.remote.httpx.Client", partial(httpx.Client, transport=httpx.MockTransport(answer)))
    file = tmp_path / "a.py"
    file.write_text("x = 1")
    assert main(["submit", EXERCISE, str(file), "--server", "http://serveur", "--token", "jeton"]) == 0
    assert capsys.readouterr().out == "Reçu ; résultat après la publication par l’enseignant.\n"
    assert asked == ["POST", "GET"]


def test_an_exchange_that_is_cut_off_is_made_again_under_the_same_name(
    monkeypatch: Any, tmp_path: Path, capsys: Any
) -> None:
    """The first sending may have arrived: its name tells the server that the others are the same."""
    held = {"url": "/api/v1/submissions/1", "status": "running", "held": True}
    posts = iter([httpx.ReadError("cut"), httpx.Response(503), httpx.Response(202, json={**held, "held": False})])
    looks = iter([httpx.RemoteProtocolError("cut"), httpx.Response(503), httpx.Response(200, text="")])
    names = set()

    def answer(request: httpx.Request) -> httpx.Response:
        names.add(request.headers.get("Idempotency-Key") or "none")
        told = next(posts if request.method == "POST" else looks, None)
        if isinstance(told, Exception):
            raise told
        return told or httpx.Response(200, text=f"data: {json.dumps(held)}\n\n")

    monkeypatch.setattr("server.cli.submit.PAUSES", (0.0, 0.0, 0.0, 0.0))
    monkeypatch.setattr("server.cli.remote.httpx.Client", partial(httpx.Client, transport=httpx.MockTransport(answer)))
    file = tmp_path / "a.py"
    file.write_text("x = 1")
    assert main(["submit", EXERCISE, str(file), "--server", "http://serveur", "--token", "jeton"]) == 0
    assert next(posts, None) is None
    assert len(names - {"none"}) == 1
    assert "nouvel essai" in capsys.readouterr().err


@pytest.mark.usefixtures("walls_that_stand")
def test_what_is_printed_has_the_bound_of_what_is_recorded(right: Path, monkeypatch: Any, capsys: Any) -> None:
    check = CheckResult("a", "Une", False, 0, 20.0, "m" * 900_000)
    heavy = Judgement(Verdict(EXERCISE, "v1", Outcome.WRONG_ANSWER, 1, [check]))
    monkeypatch.setattr("server.grading.sandbox_grader.SandboxGrader.grade", lambda *_, **__: heavy)
    assert main(["grade", EXERCISE, str(right), "--json"]) == 1
    assert len(capsys.readouterr().out) <= VERDICT_BYTES
