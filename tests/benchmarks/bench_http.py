"""Time from submit to verdict over HTTP, on a freshly started `balise serve` that has warmed up, and where it goes.

    PYTHONPATH=. python tests/benchmarks/bench_http.py l20/poses [FILE | --mistake ID] [--count 200] [--pause 0.03]

One student, who pauses between two submissions; the client is a socket. The steps are told apart by the times that the
server itself writes in the rows of the submission and of its grading. Each figure is also told normalised: divided by
what ten million additions take in the pauses, and multiplied by 500 ms. Processor time is told by part of the service;
the program's own computing is what its process takes beyond that of a file which defines nothing.
"""

from __future__ import annotations

import argparse
import os
import re
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from uuid import UUID

import httpx

from graders.core.code.grading import CodeGrader
from server.course import load_course
from tests.benchmarks.light import PROGRAMS, Answer, Line, settle, spent
from tests.benchmarks.measure import additions, figure, median, p95, table

PROJECT = Path(__file__).resolve().parents[2]
WARM_UP, EMPTY_ROUNDS, EMPTY = 10, 40, "pass\n"
#: Milliseconds that ten million additions take on the machine that normalised figures are of; a hundredth is measured.
REFERENCE, MEASURED, TIMES = 500.0, 100_000, 100
WHOLE = "submit to verdict"
PASSWORD = "mesure de latence"


@contextmanager
def server(data: Path) -> Iterator[str]:
    """A server on a free port, without submission limits; yields its address."""
    with serving(data) as (address, _):
        yield address


@contextmanager
def serving(data: Path, project: Path = PROJECT) -> Iterator[tuple[str, int]]:
    """The same, with the number of its process; `project`: the checkout that serves."""
    environment = {**os.environ, "BALISE_SUBMISSION_REFILL_SECONDS": "0", "PYTHONPATH": str(project)}
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", str(data)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment, cwd=project) as process:
        assert process.stdout
        for line in process.stdout:
            if found := re.search(r"prête : (http://\S+?)/?$", line):
                break
        else:
            raise SystemExit("the server did not start")
        try:
            yield found[1], process.pid
        finally:
            process.terminate()


def new_token(client: httpx.Client, login: str = "banc") -> str:
    form = {"name": "Banc", "login": login, "password": PASSWORD}
    client.post("/inscription", data=form)
    page = client.post("/compte/jetons", data={"label": "banc", "password": PASSWORD}).text
    found = re.search(r'id="jeton">([^<]+)<', page)
    assert found
    return found[1]


def token_of(address: str, login: str) -> str:
    with httpx.Client(base_url=address, timeout=60) as client:
        return new_token(client, login)


@dataclass(frozen=True)
class Measured:
    """Milliseconds: of each step in each submission; of processor, of each part, for a verdict; of it, the program's
    own computing; what ten million additions took, of the wall and of the processor."""

    steps: Mapping[str, Sequence[float]]
    parts: Mapping[str, float]
    own: float
    wall: float
    processor: float

    @property
    def by_wall(self) -> float:
        return REFERENCE / self.wall

    @property
    def by_processor(self) -> float:
        return REFERENCE / self.processor


def code_of(exercise: str, mistake: str = "") -> str:
    """The exercise's solution, or the whole file of a catalogued mistake: what its folder holds of that may be less."""
    grader = load_course(render=False).exercises[exercise].grader
    assert isinstance(grader, CodeGrader)
    return next(one.source for one in grader.misconceptions if one.id == mistake) if mistake else grader.solution


def measured(exercise: str, code: str, count: int, pause: float, named: str | None = None) -> Measured:
    """On a server of its own. Raises RuntimeError for a verdict that is not `named` so (empty: not named), if given."""
    units = []
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder)) as (address, pid):
        line = Line(address, token_of(address, "banc"))

        def submitted(text: str, times: int) -> tuple[list[Answer], dict[str, float]]:
            request, answers = line.request(exercise, text), []
            before = spent(pid)
            for _ in range(times):
                time.sleep(pause)
                units.append([1000 * TIMES * seconds for seconds in additions(MEASURED)])
                answers.append(line.exchange(request))
                if answers[-1].status != 200:
                    raise RuntimeError(answers[-1].body.decode())
            time.sleep(pause)  # the next spare belongs to the last verdict
            after = spent(pid)
            return answers, {part: 1000 * (after[part] - before[part]) / times for part in after}

        settle(pid)
        submitted(code, WARM_UP)
        _, empty = submitted(EMPTY, EMPTY_ROUNDS)
        units.clear()
        answers, parts = submitted(code, count)
        line.close()
        names = {((told := answer.json()["verdict"]["diagnosis"]) and told["id"]) or "" for answer in answers}
        if named is not None and names != {named}:
            raise RuntimeError(f"{exercise}: named {names}, and not {named!r}")
        known = rows(Path(folder))
    found = [steps(answer, known) for answer in answers]
    wall, processor = (median(one) for one in zip(*units, strict=True))
    by_step = {name: [one[name] for one in found] for name in found[0]}
    return Measured(by_step, parts, max(0.0, parts[PROGRAMS] - empty[PROGRAMS]), wall, processor)


def steps(answer: Answer, known: Mapping[str, tuple[float, float, float]]) -> dict[str, float]:
    """Milliseconds of each step; `known`: when each was stored, leased to a worker, and its verdict ready."""
    told = answer.json()
    (stored, leased, judged), timings = known[told["id"]], told["verdict"]["timings"]
    return {
        WHOLE: 1000 * (answer.ended - answer.began),
        "received, to the row": 1000 * (stored - answer.began),
        "committed, to a lease": 1000 * (leased - stored),
        "leased, to a start": max(0.0, 1000 * (judged - leased) - timings["total_ms"]),
        "checks": timings["checks_ms"],
        "diagnosis": timings["diagnosis_ms"],
        "judged, to an answer": 1000 * (answer.ended - judged),
    }


def rows(data: Path) -> dict[str, tuple[float, float, float]]:
    """The three times of each submission, by its id."""
    query = (
        "SELECT submission.id, submission.created_at, grading.started_at, grading.finished_at "
        "FROM submission JOIN grading ON grading.id = submission.grading_id"
    )
    with closing(sqlite3.connect(data / "balise.sqlite3")) as database:
        found = database.execute(query).fetchall()
    return {str(UUID(identity)): tuple(map(_seconds, times)) for identity, *times in found}  # type: ignore[misc]


def _seconds(text: str) -> float:
    return datetime.fromisoformat(text).replace(tzinfo=UTC).timestamp()


def report(exercise: str, found: Measured) -> None:
    print(f"Ten million additions: {found.wall:.0f} ms of the wall, {found.processor:.0f} ms of processor\n")
    by = found.by_wall
    lines = [
        [name, *map(figure, (median(taken), p95(taken), median(taken) * by, p95(taken) * by))]
        for name, taken in found.steps.items()
    ]
    whole = found.steps[WHOLE]
    less = (median(whole) * by - found.own * found.by_processor, p95(whole) * by - found.own * found.by_processor)
    lines.append(["the same, without the program’s own computing", "", "", *map(figure, less)])
    print(table([f"`{exercise}`, ms", "p50", "p95", "p50, normalised", "p95, normalised"], lines))
    costs = {**found.parts, "all of it": sum(found.parts.values()), "of it, the program’s own computing": found.own}
    told = [[name, figure(taken), figure(taken * found.by_processor)] for name, taken in costs.items()]
    print(table(["processor, ms a verdict", "", "normalised"], told))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("exercise")
    parser.add_argument("file", type=Path, nargs="?", help="the exercise's solution, unless it is given")
    parser.add_argument("--mistake", default="", help="the whole file of a catalogued one, instead")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--pause", type=float, default=0.03, help="seconds between a verdict and the next submission")
    options = parser.parse_args()
    own = options.file.read_text(encoding="utf-8") if options.file else ""
    code = own or code_of(options.exercise, options.mistake)
    report(options.exercise, measured(options.exercise, code, options.count, options.pause))


if __name__ == "__main__":
    main()
