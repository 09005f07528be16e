"""The whole service in real processes: a story of submissions, and kill -9 in the middle of it."""

from __future__ import annotations

import os
import signal
import sqlite3
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from server.cli import main
from server.course import Course, Exercise
from tests.support.live import AUDIT, RUNNING, WAITING, Live, alive, balise, children, count, rows, state_of, until
from tests.support.service import EXERCISE


@pytest.fixture
def data(tmp_path: Path) -> Iterator[Path]:
    """A data folder; whatever still runs on it at the end is ended."""
    yield tmp_path / "data"
    lock = tmp_path / "data" / "balise.lock"
    pid = int(lock.read_text() or 0) if lock.exists() else 0
    if pid and alive(pid) and str(tmp_path).encode() in Path(f"/proc/{pid}/cmdline").read_bytes():
        os.kill(pid, signal.SIGKILL)


@pytest.mark.long
@pytest.mark.parametrize("warm_up", ["0", pytest.param("1", marks=pytest.mark.slow)])
def test_a_service_in_real_processes(
    data: Path, tmp_path: Path, course: Course, capsys: pytest.CaptureFixture[str], warm_up: str
) -> None:
    """One story, as starting a server takes seconds: the terminal, kill -9 of a worker, of the server, a clean stop.

    That a worker rehearses each grader, and tells of one that fails, is a test of tests/grading/test_process.py; that
    what is rehearsed works, of all those that grade it.
    """
    exercise = course.exercises[EXERCISE]
    live = Live(data, program="server", BALISE_WORKERS="1")
    live.sign_up_teacher()
    token = live.token()
    headers = {"Authorization": f"Bearer {token}"}

    the_terminal_submits(live.address, token, exercise, tmp_path, capsys)
    another_server_is_refused(live, data, tmp_path, capsys)
    figures_are_drawn_by_another_process(live, course)

    with closing(sqlite3.connect(data / "balise.sqlite3")) as connection:
        connection.executescript(AUDIT)
    sent = send_slow_ones(live, headers, exercise)
    kill_a_worker(live, data)
    kill_the_server(live, data)
    let_them_be_graded_at_once(data, exercise)
    live = Live(data, BALISE_WORKERS="1", BALISE_WARM_UP=warm_up)
    assert "/bienvenue/" not in live.output
    until(lambda: count(data, WAITING) == 0, "everything is graded")
    graded = Counter(one for (one,) in rows(data, "SELECT id FROM audit"))
    assert graded == Counter(one.replace("-", "") for one in sent), "each is graded exactly once"
    for one in sent:
        verdict = live.client.get(f"/api/v1/submissions/{one}", headers=headers).json()["verdict"]
        assert (verdict["outcome"], verdict["score"]) == ("ok", 1.0)
    stop_while_someone_watches(live, headers)


def the_terminal_submits(
    address: str, token: str, exercise: Exercise, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    right, wrong = folder / "right.py", folder / "wrong.py"
    right.write_text(exercise.solution)
    misconception = exercise.grader.misconceptions[0]
    wrong.write_text(misconception.source)

    def submit(path: Path, name: str = EXERCISE, server: str = address, token: str = token) -> tuple[int, str]:
        status = main(["submit", name, str(path), "--server", server, "--token", token])
        told = capsys.readouterr()
        return status, told.out + told.err

    done = balise("submit", EXERCISE, str(right), "--server", address, "--token", token)
    assert (done.returncode, "20/20" in done.stdout) == (0, True)
    status, told = submit(wrong)
    assert (status, misconception.title in told) == (1, True)
    answers, broken = folder / "answers.json", folder / "broken.json"
    answers.write_text('{"ds": NaN, "dtheta": "0,1"}')
    broken.write_text("[1]")
    status, told = submit(answers, name="l20/calcul_odometrie")
    assert (status, "réponse illisible" in told) == (1, True)
    for refused, reason in [
        (submit(broken, name="l20/calcul_odometrie"), "objet JSON"),
        (submit(right, name="l20/calcul_odometrie"), "#/answers : valeur manquante"),
        (submit(answers), "#/code : valeur manquante"),
        (submit(right, token="balise_faux"), "jeton"),
        (submit(right, name="l20/inconnu"), "n’existe pas"),
        (submit(right, server="http://127.0.0.1:1"), "impossible de joindre"),
        (submit(right, server=address.replace("http", "https")), "chiffrée"),
        (submit(right, server="balise.test"), "http://"),
        (submit(folder / "absent.py"), "n’existe pas"),
    ]:
        assert refused[0] == 2
        assert reason in refused[1]


def another_server_is_refused(live: Live, data: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    port = live.address.rpartition(":")[2]
    assert main(["serve", "--port", port, "--data", str(folder / "other")]) == 2
    assert "déjà pris" in capsys.readouterr().err
    assert main(["serve", "--port", "0", "--data", str(data)]) == 2
    assert "utilise déjà" in capsys.readouterr().err
    assert int((data / "balise.lock").read_text()) == live.process.pid


def figures_are_drawn_by_another_process(live: Live, course: Course) -> None:
    """The one that answers does not load matplotlib, any import of which maps its compiled modules."""
    name = next(iter(course.modules["l20"].drawings))
    answer = live.client.get(f"/l20/figures/{name}.svg")
    assert (answer.status_code, b"<svg" in answer.content) == (200, True)
    mapped = Path(f"/proc/{live.process.pid}/maps").read_text()
    assert ("/numpy/" in mapped, "/matplotlib/" in mapped) == (True, False)


def send_slow_ones(live: Live, headers: dict[str, str], exercise: Exercise) -> list[str]:
    """The last of them are still waiting when the others have been graded beside a test that is held up."""
    sent = []
    for seconds in (0.4, 0.4, 1.5, 1.5, 1.5, 1.5):
        slow = f"import time\ntime.sleep({seconds})\n" + exercise.solution
        answer = live.client.post("/api/v1/submissions", json={"exercise": EXERCISE, "code": slow}, headers=headers)
        assert answer.status_code == 202
        sent.append(answer.json()["id"])
    return sent


def kill_a_worker(live: Live, data: Path) -> None:
    victim = live.workers()[0]
    until(lambda: is_stopped_in_a_grading(victim, data), "one is being graded")
    ((job,),) = rows(data, f"SELECT id FROM job WHERE {RUNNING}")
    below = children(victim)
    os.kill(victim, signal.SIGKILL)
    until(lambda: not any(map(alive, [victim, *below])), "the worker's own processes are gone")
    until(lambda: count(data, f"id = '{job}' AND tries < 2", "job") == 0, "what it was grading is taken again")


def is_stopped_in_a_grading(worker: int, data: Path) -> bool:
    """Stop a worker; let it go on where it has just ended one grading and not begun another."""
    os.kill(worker, signal.SIGSTOP)
    until(lambda: state_of(worker) == "T", "it is stopped")
    if count(data, RUNNING, "job") == 1:
        return True
    os.kill(worker, signal.SIGCONT)
    return False


def kill_the_server(live: Live, data: Path) -> None:
    assert count(data, WAITING) >= 2, "it is killed in the middle"
    below = live.kill()
    assert len(below) >= 2
    until(lambda: not any(map(alive, below)), "everything below the server is gone")
    assert count(data, WAITING) >= 1


def let_them_be_graded_at_once(data: Path, exercise: Exercise) -> None:
    """They have done their part: that the server is killed while they wait."""
    with closing(sqlite3.connect(data / "balise.sqlite3")) as connection, connection:
        connection.execute(f"UPDATE submission SET source = ? WHERE {WAITING}", (exercise.solution.encode(),))


def stop_while_someone_watches(live: Live, headers: dict[str, str]) -> None:
    """An open stream must not keep the server from stopping, nor workers that are told to stop with it trouble it."""
    body = {"exercise": EXERCISE, "code": "import time\ntime.sleep(60)\n"}
    url = live.client.post("/api/v1/submissions", json=body, headers=headers).json()["url"]
    below = children(live.process.pid)
    with live.client.stream("GET", f"{url}/events", headers=headers) as answer:
        assert next(answer.iter_lines()) == "event: status"
        before = live.errors.read_text()
        os.killpg(live.process.pid, signal.SIGTERM)
        assert live.process.wait(300) == 0
    live.close()
    until(lambda: not any(map(alive, below)), "nothing is left running")
    told = live.errors.read_text()
    assert "Traceback" not in told
    assert "does not work" not in told, "no grader failed at what is rehearsed as a worker starts"
    assert "ERROR" not in told.removeprefix(before)
