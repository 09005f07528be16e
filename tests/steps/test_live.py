"""A real service: a call, a cell and the case of a verdict are followed by the process that runs cells."""

from __future__ import annotations

from pathlib import Path

import pytest

from server.course import Course
from tests.support.live import Live, until


@pytest.mark.slow
def test_a_call_a_cell_and_a_case_are_followed(tmp_path: Path, course: Course) -> None:
    exercise = course.exercises["l20/poses"]
    code = exercise.solution.replace("ramener(ta + tb)", "ta + tb")
    live = Live(tmp_path / "data", BALISE_WORKERS="1")
    try:
        cell = live.client.post("/l20/cellules/pas", json={"code": "x = H\nx + 1"}).json()
        assert (cell["stdout"], cell["steps"][-1]["event"]) == ("17\n", "return")
        call = {"code": code, "call": "composer((0, 0, 2), (0, 0, 2))"}
        own = live.client.post("/l20/exercices/poses/pas", json=call).json()
        assert own["end"]["value"]["values"] == ["0.0", "0.0", "4.0"]
        printing = "print('avant')\ndef f(x):\n    print('dans')\n    return 1 / x\n"
        ends = []
        for call in ("f(2)", "f(0)", ""):
            body = {"code": printing, "call": call, "plain": True}
            plain = live.client.post("/l20/exercices/poses/pas", json=body).json()
            assert (plain["steps"], plain["frames"], plain["left_out"]) == ([], [], [])
            ends.append((plain["stdout"], plain["end"]["kind"], plain["end"].get("line")))
        assert ends == [
            ("avant\ndans\n", "returned", None),
            ("avant\ndans\n", "fault", 4),
            ("avant\n", "returned", None),
        ]
        loop = {"code": "def f():\n    while True:\n        pass\n", "call": "f()", "plain": True}
        assert "temps" in live.client.post("/l20/exercices/poses/pas", json=loop).json()["end"]["title"].lower()
        sent = live.client.post("/l20/exercices/poses/soumissions", data={"code": code}).headers["location"]
        address = sent.partition("?")[0]
        until(lambda: "verification" in live.client.get(f"{address}/verdict").text, "it is graded")
        trace = live.client.post(f"{address}/pas", json={"check": "composer_tours"}).json()
        assert (trace["frames"][0]["function"], trace["end"]["kind"], trace["left_out"]) == ("composer", "returned", [])
        assert trace["mark"]["line"] == 1 + code[: code.index("ta + tb]")].count("\n")
    finally:
        live.process.terminate()
        live.process.wait()
        live.close()
