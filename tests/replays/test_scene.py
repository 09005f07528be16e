"""The author's words: what cannot be shown is refused, what can comes back from the wire as it was."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from graders.scene.packing import packed, picture, rounded
from graders.scene.parameters import Choice, Dragged, Draw, Event, RefusedError, Slider, Switch
from graders.scene.replay import (
    Chart,
    Ellipse,
    Frame,
    Grid,
    Labels,
    Points,
    Pose,
    Rays,
    Replay,
    SceneError,
    Segments,
    Series,
    View,
    decimal,
)
from tests.support.replays import cells, unpacked

NUMBERS = st.floats(-3e4, 3e4, allow_nan=False)


@given(arrays(np.float64, st.tuples(st.integers(0, 20), st.integers(2, 4)), elements=NUMBERS))
def test_arrays_come_back_to_a_part_in_thirty_thousand(array: np.ndarray) -> None:
    there_and_back = unpacked(packed(array))
    coarse = 0.5e-4 + 10 * np.abs(array).max(initial=0.0) / 32767 / 2
    np.testing.assert_allclose(there_and_back, array, atol=coarse * 1.0001)


@given(arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 400)), elements=st.sampled_from([0, 0, 0, 7, 255])))
def test_pictures_come_back_as_they_are(bytes_: np.ndarray) -> None:
    grid = picture(bytes_ / 255.0)
    np.testing.assert_array_equal(np.rint(255 * cells(grid)), bytes_)


def test_numbers_are_short_and_gaps_are_null() -> None:
    assert rounded(123.456789) == 123.5
    assert rounded(5.0) == 5
    assert isinstance(rounded(5.0), int)
    assert rounded(1.23456e-9) == 1.235e-9
    assert rounded(float("nan")) is None
    assert rounded(float("inf")) is None
    assert decimal(-1.25, 2) == "−1,25"


@pytest.mark.parametrize(
    "layer",
    [
        Points([[0.0, np.nan]], "truth"),
        Points([[0.0, 1.0, 2.0]], "truth"),
        Points([[0.0, 1.0]], "truth", weights=[0.1, 0.2]),
        Points([[0.0, 1.0]], "truth", headings=[]),
        Pose([0.0, np.inf, 0.0], "truth"),
        Rays([0.0, 0.0], [[1.0, np.nan]]),
        Segments([[0.0, 0.0]], [[1.0, 1.0], [2.0, 2.0]], "ink"),
        Labels([[0.0, 0.0]], ["a", "b"]),
        Grid([[0.0, np.nan]], "walls"),
        Grid([], "walls"),
    ],
)
def test_a_layer_that_cannot_be_drawn_is_refused(layer: Points) -> None:
    with pytest.raises(SceneError):
        layer.wire()


def test_a_scene_that_does_not_hold_together_is_refused() -> None:
    view, frames, said = View(0, 0, 1, 1), [Frame(), Frame()], ["Voilà."]
    line = Points([[0.0, 0.0]], "ink", until=[1])
    short = Chart("Erreur", [Series("e", "alert", [1.0, 2.0])], cursor=[0.0])
    for scene in (
        Replay(view, [], said),
        Replay(view, frames, []),
        Replay(View(0, 0, 0, 1), frames, said),
        Replay(view, frames, said, layers=[line]),
        Replay(view, frames, said, charts=[short]),
        Replay(view, frames, said, charts=[Chart("Erreur", [Series("e", "alert", [1.0], [1.0, 2.0])])]),
    ):
        with pytest.raises(SceneError):
            scene.wire()


def test_an_ellipse_holds_its_covariance() -> None:
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    shape = Ellipse([1.0, 2.0], turn @ np.diag([4.0, 0.25]) @ turn.T, "second", sigmas=2.0).wire()["at"]
    np.testing.assert_allclose(shape[:4], [1.0, 2.0, 4.0, 1.0], atol=1e-3)
    assert np.isclose(np.tan(shape[4]), np.tan(0.4), atol=1e-3)


@given(st.floats(0.0, 1.0), st.sampled_from([0.01, 0.05, 0.1, 0.25]))
def test_a_slider_brings_values_to_its_step_and_to_themselves(value: float, step: float) -> None:
    slider = Slider("σ", 0.0, 1.0, step, 0.5)
    read = slider.read(f"{value:.6f}")
    assert isinstance(read, float)
    assert abs(read - value) <= step / 2 + 1e-6
    assert slider.read(str(read)) == read


@pytest.mark.parametrize(
    ("parameter", "text"),
    [
        (Slider("n", 0, 10, 1, 5), text)
        for text in ("", "11", "-1", "nan", "NaN", "inf", "1e3", "0x3", "٣", "1 ", "+1", "1,5", "5;", "9" * 30)
    ]
    + [(Choice("c", (("a", "A"),), "a"), text) for text in ("", "A", "b")]
    + [(Switch("s"), text) for text in ("", "2", "true", "on")]
    + [(Event("e", "u", 5), text) for text in ("-2", "5", "x")]
    + [(Draw(), text) for text in ("-1", "100", "1e1")]
    + [
        (Dragged("r", (1.0, 1.0, 0.0), (0.0, 0.0, 2.0, 2.0)), text)
        for text in ("1,1", "1,1,0,0", "3,1,0", "1,-1,0", "1,1,nan", "1,1,1000", "a,b,c", ",,")
    ],
)
def test_values_that_are_not_taken(parameter: Slider, text: str) -> None:
    with pytest.raises(RefusedError):
        parameter.read(text)


def test_values_that_are() -> None:
    assert Slider("n", 0, 10, 1, 5).read("7.2") == 7
    assert isinstance(Slider("n", 0, 10, 1, 5).read("7"), int)
    assert Event("e", "u", 5).read("-1") is None
    assert Event("e", "u", 5).read("4") == 4
    dragged = Dragged("r", (1.0, 1.0, 0.0), (0.0, 0.0, 2.0, 2.0), step=0.5, turn=np.pi / 4)
    assert dragged.read("1.3,0.2,7.0") == (1.5, 0.0, round(np.pi / 4, 6))
