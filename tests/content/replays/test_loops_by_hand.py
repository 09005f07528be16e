"""The replay in which loops are judged one by one: the text's figures, and what the question tells of each loop."""

from __future__ import annotations

import re

import numpy as np

from curriculum.l20.rejeux import boucles_a_la_main as replay
from curriculum.l20.rejeux import laboratoire
from tests.support.replays import scene, unpacked
from tests.support.shipped import ROOT

TRUE = {f"b{k}": "1" for k in (2, 3, 4, 7, 8)}


def squares(**settings: str) -> int:
    found = re.search(r"([\d\u202f]+) carrés", str(scene("boucles-a-la-main", **settings)["summary"][1]))
    assert found
    return int(found[1].replace("\u202f", ""))


def test_true_loops_make_the_map_sharper_and_each_false_one_blurs_it() -> None:
    none, best = squares(), squares(**TRUE)
    text = (ROOT / "curriculum/l20/seances/slam.md").read_text(encoding="utf-8").replace("\\,", "")
    assert f"${none}$ sans boucle, ${best}$ avec les cinq vraies" in text
    assert best < min(squares(**TRUE, **{name: "1"}) for name in ("b1", "b5", "b6")) < none


def test_the_count_judges_all_loops_together_and_not_the_last_one() -> None:
    """What the text warns of: a true loop that adds squares, and two false ones that agree."""
    none, second, third = squares(), squares(b2="1"), squares(b2="1", b3="1")
    assert third - second == 9
    assert squares(b5="1", b6="1") < none < min(squares(b5="1"), squares(b6="1"))


def test_no_scan_that_is_examined_is_cut_at_the_frame() -> None:
    (x0, y0, x1, y1), frames = scene("boucles-a-la-main")["box"], scene("boucles-a-la-main")["frames"]
    for frame in frames:
        points = np.vstack([unpacked(layer["at"]) for layer in frame["layers"] if layer["kind"] == "points"])
        assert np.all(points > [x0, y0])
        assert np.all(points < [x1, y1])


def test_what_the_question_tells_of_each_loop() -> None:
    closing, chosen = laboratoire.loops(), np.array(replay.CHOSEN)
    asked = np.array([np.hypot(*replay.correction(loop)) for loop in replay.CHOSEN])
    false = closing.false[chosen]
    assert (np.flatnonzero(false) + 1).tolist() == [1, 5, 6]
    assert asked[false].min() > 1.0
    assert 0.28 < asked[~false].min() < asked[~false].max() < 0.7
    captions = [frame["caption"] for frame in scene("boucles-a-la-main")["frames"]]
    assert "90 %" in captions[0]
    assert "70 %" in captions[7]
    assert not any("fausse" in caption for caption in captions)


def test_the_answer_is_told_only_when_it_is_asked() -> None:
    assert scene("boucles-a-la-main", b1="1")["summary"][0] == "1 boucle acceptée sur 8."
    told = scene("boucles-a-la-main", b1="1", reponse="1")
    assert told["summary"][0].startswith("1 boucle acceptée sur 8, dont 1 fausse.")
    assert told["frames"][0]["caption"].endswith("Elle est fausse.")
    assert any(layer["color"] == "alert" for layer in told["layers"] if len(layer.get("at", "")))
