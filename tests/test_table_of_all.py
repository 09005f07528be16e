"""The table of all that is measured (`tests/benchmarks/all.py`): what is met, what is normalised, and what fails."""

from __future__ import annotations

import os
import re
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from server.base.files import ROOT
from tests.benchmarks import gather
from tests.benchmarks.euros import Price
from tests.benchmarks.measure import ADDITIONS, REFERENCE, Goal, Pace, Row
from tests.benchmarks.parts import PARTS, Part, Wanted, timed
from tests.benchmarks.region import PAGES_A_SUBMISSION, WRONG, Costs
from tests.support.live import alive

HERE = Wanted()


@pytest.mark.parametrize(
    ("row", "met"),
    [
        (Row("at most", "ms", 12.0, goal=Goal(12)), True),
        (Row("at most", "ms", 12.1, goal=Goal(12)), False),
        (Row("at least", "×", 12.1, goal=Goal(12, at_least=True)), True),
        (Row("at least", "×", 11.9, goal=Goal(12, at_least=True)), False),
        (Row("a slow machine", "ms", 20.0, normalised=10.0, goal=Goal(12)), True),
        (Row("a quick one", "ms", 10.0, normalised=20.0, goal=Goal(12)), False),
        (Row("nothing is asked", "ms", 10.0), None),
        (Row.missing("nothing was measured", "no data", Goal(12)), None),
    ],
)
def test_a_goal_is_held_against_what_was_normalised_if_it_was(row: Row, met: bool | None) -> None:
    assert row.met is met
    assert gather.line(row)[-1] == {True: "met", False: "**not met**", None: ""}[met]


def test_a_machine_half_as_quick_takes_as_long_once_normalised() -> None:
    quick, slow = Pace(), Pace()
    quick.samples, slow.samples = [(0.5, 0.4), (0.5, 0.4)], [(1.0, 0.8), (1.0, 0.8), (9.0, 0.8)]
    assert 3.0 * quick.wall == pytest.approx(6.0 * slow.wall) == pytest.approx(3.0)
    assert 2.0 * quick.processor == pytest.approx(4.0 * slow.processor) == pytest.approx(2.5)


def test_a_sample_tells_what_all_the_additions_would_take(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.benchmarks.measure.additions", lambda count: (REFERENCE * count / ADDITIONS, 0.02))
    pace = Pace()
    pace.sample()
    assert pace.wall == pytest.approx(1.0)


def test_what_the_machine_was_worth_is_told_beside_the_figures() -> None:
    rows = [Row("as a half", "ms", 10.0, 10.0), Row("as one", "s", 4.0, 2.0), Row("others", "a second", 70.0, 160.0)]
    assert gather.weather([*rows, Row("raw", "ms", 3.0)]) == "ten million additions: 0.50 to 1.00 s"
    assert gather.weather([Row("raw", "ms", 3.0)]) == ""


def fine(_: Wanted) -> list[Row]:
    print("this is no row")
    return [Row("a subject", "ms", 1.0)]


def raising(_: Wanted) -> list[Row]:
    raise ArithmeticError("not at the optimum\nin the third line")


def leaving(_: Wanted) -> list[Row]:
    raise SystemExit("this benchmark needs scipy")


def killed(_: Wanted) -> list[Row]:
    os.kill(os.getpid(), signal.SIGKILL)
    return []


def gone(_: Wanted) -> list[Row]:
    os._exit(0)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (raising, "ArithmeticError: not at the optimum"),
        (leaving, "SystemExit: this benchmark needs scipy"),
        (killed, "ended by signal 9"),
        (gone, "ended without an answer"),
    ],
)
def test_a_benchmark_that_fails_leaves_its_reason_and_the_others_go_on(
    rows: Callable[[Wanted], list[Row]], told: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(gather, "PARTS", (Part("it", rows), Part("after", fine)))
    monkeypatch.setattr(os, "environ", dict(os.environ))
    assert gather.main([]) == 1
    output = capfd.readouterr().out
    assert f"| it | not measured: failed: {told} |" in output
    assert "| a subject | 1 ms |" in output
    assert "no row" not in output


def test_a_benchmark_that_lasts_is_given_up_with_what_it_has_started(tmp_path: Path) -> None:
    kept = tmp_path / "pid"

    def lasting(_: Wanted) -> list[Row]:
        if (child := os.fork()) == 0:
            time.sleep(60)
            os._exit(0)
        kept.write_text(str(child))
        time.sleep(60)
        return []

    assert gather.found_by(Part("it", lasting, patience=0.5), HERE) == "took more than 0.5 s"
    started = kept.read_text() if kept.exists() else ""  # a machine at its end may not have come so far
    deadline = time.monotonic() + 300
    while started and alive(int(started)) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not (started and alive(int(started)))


def test_parts_are_chosen_by_a_word_and_what_takes_long_is_asked_for() -> None:
    names = [part.name for part in PARTS]
    assert len(names) == len(set(names))
    usual = {part.name for part in gather.chosen([], quick=False, suite=False)}
    assert set(names) - usual == {"suite"}
    assert {part.name for part in gather.chosen([], quick=True, suite=True)} >= {"suite", "exchange"}
    assert [part.name for part in gather.chosen(["suite", "pose"], quick=True, suite=False)] == ["pose graph", "suite"]


def test_what_cannot_be_measured_here_says_why() -> None:
    part = next(part for part in PARTS if part.name == "lighthouse")
    (row,) = part.rows(HERE)
    assert row.met is None
    assert "npm install lighthouse" in gather.line(row)[1]


def test_a_million_times_a_tenth_of_a_second_at_three_cents_an_hour() -> None:
    assert Price(0.03, {}).million(0.1) == pytest.approx(100_000 / 3600 * 0.03)


def test_the_page_on_costs_multiplies_rightly() -> None:
    """The euros of its table, from the processor time beside them; what others start, from what was published."""
    text = (ROOT / "server" / "docs" / "combien_de_machines.md").read_text(encoding="utf-8")
    told = re.findall(r"^\| ([^|]+) \| [^|]+ \| (\d+) ms \| (\d+,\d\d) \|$", text, re.MULTILINE)
    taken = {who: float(taken) / 1000 for who, taken, _ in told}
    price, costs = Price.read(), Costs.read()
    assert len(taken) == 6
    for who, _, euros in told:
        assert float(euros.replace(",", ".")) == pytest.approx(price.million(taken[who]), abs=0.006)
    pages = PAGES_A_SUBMISSION * costs.request + WRONG * costs.figure
    assert taken["Balise, un exercice d’un cours"] == pytest.approx(
        costs.lesson + pages + costs.database + costs.nats, abs=0.001
    )
    assert taken["PrairieLearn"] == taken["Artemis"] == price.containers["on an SSD"]
    disk = price.containers["on a hard disk"]
    assert f"{1000 * disk:.0f} ms" in text.replace("1 157", "1157")
    assert f"{price.million(disk):.2f} €".replace(".", ",") in text


def test_a_command_is_timed_with_its_processor_and_one_that_fails_says_what_it_said() -> None:
    busy = "import time\nwhile time.process_time() < 0.05: pass"
    row = timed("nothing", [sys.executable, "-S", "-c", busy], Goal(1000))
    assert row.met
    assert (row.measured or 0.0) >= 0.05
    assert row.processor
    with pytest.raises(RuntimeError, match="nothing: it broke"):
        timed("nothing", [sys.executable, "-S", "-c", "import sys; sys.exit('it broke')"], None)
