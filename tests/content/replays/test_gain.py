"""The gain that one moves by hand is the Kalman filter's, and what its page says of it is so."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from reference.filters.gaussian import joseph_update
from reference.filters.kalman import KalmanFilter
from reference.filters.models import LinearGaussian
from tests.content.replays.hand_scripts import FOLDER, Script, start

STEPS = 20


@cache
def script() -> Script:
    return Script("gain", "calcul.js")


def line(move: float, noise: float) -> LinearGaussian:
    return LinearGaussian(F=[[1.0]], B=[[1.0]], Q=[[move**2]], H=[[1.0]], R=[[noise**2]])


@pytest.mark.parametrize(("spread", "z", "noise"), [(1.12, 5.6, 0.5), (0.2, 8.0, 0.5), (2.0, 0.2, 0.1)])
def test_the_correction_is_that_of_the_filter_and_of_the_product_of_the_bells(
    spread: float, z: float, noise: float
) -> None:
    found = script().value("fuse(5, s, z, n)", s=spread, z=z, n=noise)
    filtered = KalmanFilter(line(0.5, noise), [5.0], [[spread**2]])
    filtered.correct([z])
    assert filtered.innovation is not None
    assert [found["mean"], found["spread"] ** 2] == pytest.approx(
        [filtered.mean[0], filtered.covariance[0, 0]], rel=1e-9
    )
    assert found["surprise"] ** 2 == pytest.approx(filtered.innovation.nis, rel=1e-9)
    x = np.linspace(-5.0, 15.0, 4001)
    product, one = script().value(
        "[x.map((a) => bell(a, 5, s) * bell(a, z, n)), x.map((a) => bell(a, f.mean, f.spread))]",
        x=x.tolist(), s=spread, z=z, n=noise, f=found,
    )  # fmt: skip
    np.testing.assert_allclose(np.array(product) / np.trapezoid(product, x), one, atol=1e-6)


@pytest.mark.parametrize("fixed", [None, 0.0, 0.3, 1.0])
def test_a_path_and_its_typical_error_are_those_of_the_filter(fixed: float | None) -> None:
    spread, move, noise, truth = 1.3, 0.4, 0.7, 2.0
    rng = np.random.default_rng(3)
    moves, readings = rng.normal(size=(2, STEPS))
    used, typical, errors = script().value(
        "[gains(s, m, n, 20, f), typical(s, m, n, gains(s, m, n, 20, f)), path(s, m, n, gains(s, m, n, 20, f), w, v)]",
        s=spread, m=move, n=noise, f=fixed, w=moves.tolist(), v=readings.tolist(),
    )  # fmt: skip
    filtered = KalmanFilter(line(move, noise), [truth + spread * moves[0]], [[spread**2]])
    estimate, variance = filtered.mean[0], spread**2
    for k in range(STEPS):
        if k:
            truth += 1.0 - move * moves[k]
            estimate, variance = estimate + 1.0, variance + move**2
            filtered.predict([1.0])
        filtered.correct([truth + noise * readings[k]])
        gain = np.array([[used[k]]])
        estimate += used[k] * (truth + noise * readings[k] - estimate)
        variance = joseph_update(np.array([[variance]]), gain, np.eye(1), np.array([[noise**2]]))[0, 0]
        assert [typical[k] ** 2, errors[k]] == pytest.approx([variance, estimate - truth], rel=1e-9, abs=1e-12)
        if fixed is None:
            assert [estimate, variance] == pytest.approx([filtered.mean[0], filtered.covariance[0, 0]], rel=1e-9)


def test_no_gain_that_stays_the_same_does_better_than_the_filter() -> None:
    call = "g.map((f) => typical(1.12, 0.5, 0.5, gains(1.12, 0.5, 0.5, 20, f)))"
    fixed = np.array(script().value(call, g=[k / 100 for k in range(101)]))
    best = np.array(script().value("typical(1.12, 0.5, 0.5, gains(1.12, 0.5, 0.5, 20))"))
    assert np.all(fixed >= best - 1e-12)


def test_what_the_page_says_of_the_gain() -> None:
    text = (FOLDER.parent / "cours" / "filtre-bayesien.md").read_text(encoding="utf-8")
    data = start("gain")["data"]
    caption = text.split("::: manipulation gain\n")[1].split(":::")[0]

    def end(fixed: float | None) -> list[float]:
        used = "gains(1.12, m, 0.5, 20, f)"
        call = f"[{used}[19], typical(1.12, m, 0.5, {used})[19]]"
        found: list[float] = script().value(call, m=data["move"], f=fixed)
        return found

    sure = script().value("fuse(5, 0.2, 8, 0.5)")
    assert sure["mean"] < 5.5
    told = [sure["gain"], *end(None), end(0.1)[1], end(1.0)[1]]
    for number in (f"{one:.2f}".replace(".", ",") for one in told):
        assert number in caption
    begun = script().value("fuse(p, 1.12, z, 0.5)", p=data["predicted"], z=data["measured"])
    assert f"{begun['mean']:.1f}, {begun['spread']:.2f}" == "5.5, 0.46", "the example that is worked by hand"
