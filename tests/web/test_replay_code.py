"""A counterexample is replayed as it stands: its code, at the end of one's file, gives again what was obtained."""

from __future__ import annotations

import contextlib
import io
import sys
from pathlib import Path

import numpy as np
import pytest

from graders.core.code.grading import CodeGrader
from graders.core.contract.local import LOCAL
from graders.core.contract.streams import stream
from server.course import FunctionSpec
from server.web.replay_code import write_replay_code
from server.web.verdicts import build_verdict_view
from tests.support.quick import the_course

KIT = str(Path(__file__).parents[2] / "curriculum" / "l20" / "kit")
WRONG = {
    "l20/odometrie": "def odometrie(pose, ds_g, ds_d, L):\n    return np.array([0.0, 0.0, 0.25])\n",
    "l20/predire2d": "def corriger2d(bel, scan_obs, sigma=0.5):\n    return 1.0 * libres * float(len(scan_obs) + H)\n",
    "l20/mcl": "def initialiser(n):\n    return np.full((n, 3), PORTEE_MAX)\n",
}


@pytest.mark.parametrize("exercise", WRONG)
def test_a_counterexample_is_a_program(exercise: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its function, map, range and seed are those of the check; here the code is put at the end of the file and run."""
    known, source = the_course().exercises[exercise], WRONG[exercise]
    assert isinstance(known.grader, CodeGrader)
    verdict = known.grader.grade(source.encode(), LOCAL, seed=5, version="v").verdict
    kit = known.grader.kit(stream(5, "kit"))
    view = build_verdict_view(verdict, "/figures", functions=known.functions, world=(kit, known.solution))
    codes = [
        check.counterexample.code
        for check, judged in zip(view.checks, verdict.checks, strict=True)
        if check.counterexample and judged.cause is None and "print(" in check.counterexample.code
    ]
    assert codes
    monkeypatch.syspath_prepend(KIT)
    for code in codes:
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(f"from l20 import *\n{source}\n{code}\n", {"__name__": "__main__", "np": np})
        assert said.getvalue().strip()
    sys.modules.pop("l20", None)


def test_what_was_cut_short_is_no_program() -> None:
    functions = [FunctionSpec("f", "f(x)", "", "")]
    assert write_replay_code({"x": {"forme": [40, 50], "premiers": [1.5]}}, functions, None) == ""
    assert write_replay_code({"x": [1.0, 2.0]}, functions, None) == (
        "import numpy as np\nx = np.array([1.0, 2.0])\nprint(f(x))"
    )
    sparse = {"x (2, 3), cases (y, x) non nulles": {"(1, 2)": 0.5}}
    assert "x = np.zeros((2, 3))\nx[1, 2] = 0.5\nprint(f(x))" in write_replay_code(sparse, functions, None)
