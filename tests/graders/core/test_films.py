"""What a program did is kept as plain JSON within a bound of its own, and becomes a replay when somebody looks."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graders.core.contract.bounds import VERDICT_BYTES, json_size, limit_size
from graders.core.contract.films import FILM_BYTES, drop_heaviest_films, film_to_json
from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from graders.scene.films import wire
from graders.scene.replay import Chart, Frame, Key, Mark, Points, Replay, SceneError, Series, View
from server.base.files import ROOT

FLOATS = st.floats(allow_nan=True, allow_infinity=True)
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | FLOATS | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=50)
@given(st.dictionaries(st.text(max_size=3), PLAIN, max_size=4))
def test_a_film_is_strict_json_and_the_same_but_for_what_is_not_finite(data: dict[str, Any]) -> None:
    film = film_to_json(data)
    text = json.dumps(film, allow_nan=False)
    finite = json.loads(json.dumps(data), parse_constant=lambda _: None)
    assert json.loads(text) == finite


def test_arrays_and_tuples_are_lists() -> None:
    film = film_to_json({"kind": "any", "at": np.array([[1, 2]]), "end": (np.float64(0.5), np.nan), "n": np.int64(3)})
    assert film == {"kind": "any", "at": [[1, 2]], "end": [0.5, None], "n": 3}


def test_a_film_that_is_too_heavy_is_left_out() -> None:
    assert film_to_json({"kind": "any", "at": np.zeros(FILM_BYTES)}) is None


@pytest.mark.parametrize("value", [1j, {(1, 2): 3}, 10**5000, object()], ids=["complex", "key", "integer", "object"])
def test_what_no_film_is_made_of_is_logged_and_costs_no_verdict(value: Any, caplog: pytest.LogCaptureFixture) -> None:
    assert film_to_json({"kind": "any", "z": value, "nan": float("nan")}) is None
    assert "not made of plain values" in caplog.text


@settings(max_examples=50)
@given(st.lists(st.integers(0, 500), max_size=8), st.integers(0, 1500))
def test_the_heaviest_films_are_left_out_and_no_more_than_must_be(sizes: list[int], most: int) -> None:
    films = {f"c{n}": {"kind": "any", "text": "x" * size} for n, size in enumerate(sizes)}
    kept = drop_heaviest_films(films, most)
    left = [json_size(film) for check, film in films.items() if check not in kept]
    held = sum(map(json_size, kept.values()))
    assert held <= most
    assert [film for film in films.items() if film[0] in kept] == list(kept.items()), "in the order of the checks"
    if left:
        assert held + min(left) > most
        assert min(left) >= max(map(json_size, kept.values()), default=0)


def judgement(message: str, films: dict[str, Any]) -> Judgement:
    checks = [CheckResult("a", "T", False, 0, 20, message)]
    return Judgement(Verdict("m/a", "1", Outcome.WRONG_ANSWER, 7, checks), {}, films)


def test_films_and_verdict_do_not_weigh_on_each_other() -> None:
    light, heavy = {"kind": "any"}, {"kind": "any", "text": "x" * FILM_BYTES}
    kept = limit_size(judgement("m" * 2 * VERDICT_BYTES, {"a": light, "b": heavy}))
    assert kept.films == {"a": light}
    assert "coupé ici" in kept.verdict.checks[0].message
    whole = judgement("Non.", {"a": light, "b": heavy})
    assert limit_size(whole).verdict == whole.verdict
    assert limit_size(judgement("Non.", {"a": light})).films == {"a": light}


def test_a_film_becomes_a_replay_without_settings_under_the_title_of_its_check(monkeypatch: pytest.MonkeyPatch) -> None:
    def made(data: dict[str, Any]) -> Replay:
        key = Key("dot", "estimate", "votre estimation")
        return Replay(View(0, 0, 1, 1), [Frame([Points([data["at"]], "estimate")])], ["Fini."], legend=[key])

    monkeypatch.setattr("graders.l20.predire2d.replays.REPLAYS", {"points": made})
    scene = wire("l20/predire2d", {"kind": "points", "at": [0.5, 0.5]}, "Suivre le robot")
    assert (scene["title"], scene["parameters"], scene["values"], len(scene["frames"])) == (
        "Suivre le robot",
        [],
        {},
        1,
    )
    assert "« Suivre le robot »".replace(" ", "\u00a0", 0) in scene["alt"].replace("\u00a0", " ")
    assert "votre estimation" in scene["alt"]


def test_a_mark_of_a_chart_is_where_the_button_leads_unless_the_replay_says_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def made(data: dict[str, Any]) -> Replay:
        marks = [Mark(0.0, "départ", "ink"), *(Mark(x, "perdu") for x in data["marks"])]
        chart = Chart("Écart", [Series("vous", "estimate", [0, 1, 2, 3])], marks=marks, cursor=[0.0, 0.5, 1.0, 1.5])
        frames = [Frame([Points([[0, 0]], "estimate")])] * 4
        return Replay(View(0, 0, 1, 1), frames, ["."], charts=[chart], wrong=data["wrong"])

    monkeypatch.setattr("graders.l20.predire2d.replays.REPLAYS", {"points": made})
    for marks, wrong, told in (
        ([1.0], None, 2),
        ([0.7, 1.5], None, 2),
        ([1.0], 3, 3),
        ([], None, None),
        ([9.0], None, None),
    ):
        scene = wire("l20/predire2d", {"kind": "points", "marks": marks, "wrong": wrong}, "Suivre")
        assert scene.get("wrong", [None])[0] == told, (marks, wrong)
        assert wrong is not None or told is None or scene["wrong"][1].endswith("perdu")


def test_a_layer_is_in_a_panel_that_there_is_and_it_went_wrong_at_a_frame_that_there_is() -> None:
    def scene(panel: int, wrong: int | None) -> dict[str, Any]:
        frames = [Frame([Points([[0, 0]], "truth", panel=panel)])]
        return Replay(View(0, 0, 1, 1), frames, ["."], panels=("Vous", "La référence"), wrong=wrong).wire()

    told = scene(1, 0)
    assert (told["panels"], told["wrong"][0], told["frames"][0]["layers"][0]["panel"]) == (
        ["Vous", "La référence"],
        0,
        1,
    )
    for panel, wrong in ((2, None), (-1, None), (0, 1), (0, -1)):
        with pytest.raises(SceneError):
            scene(panel, wrong)


def test_neither_replays_nor_scipy_stats_are_loaded_on_the_way_to_a_verdict() -> None:
    """`scipy.stats` takes a quarter of what all graders take to load, in each process that grades."""
    loads = """if True:
        import importlib, pathlib, sys
        for path in sorted(pathlib.Path("graders").glob("*/*/grader.py")):
            importlib.import_module(".".join(path.with_suffix("").parts))
        late = ("graders.scene", "scipy.stats")
        print([name for name in sys.modules if name.startswith(late) or name.endswith(".replays")])
    """
    done = subprocess.run([sys.executable, "-c", loads], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
