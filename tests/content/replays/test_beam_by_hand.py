"""The mixture that one sets by hand, and the rounds of EM beside it, are those of `reference/`."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from curriculum.l20.manipulations.faisceau import scene
from reference.sensors.beam import BeamModel, plain_log_likelihood
from reference.sensors.plain_beam_learning import plain_em_round, plain_responsibilities
from tests.content.replays.hand_scripts import FOLDER, Script, start

MODELS = [
    BeamModel(12.0, 0.25, 0.25, 0.25, 0.25, 1.0, 1.0),
    BeamModel(12.0, 0.7, 0.1, 0.1, 0.1, 0.2, 0.5),
    BeamModel(12.0, 0.9, 0.0, 0.05, 0.05, 2.0, 3.0),
]


@cache
def script() -> Script:
    return Script("faisceau", "calcul.js")


def wire(model: BeamModel) -> dict[str, Any]:
    shares = model.shares.tolist()
    return {"shares": shares, "sigma": model.sigma, "rate": model.rate, "reach": model.max_range}


def told(model: BeamModel) -> float:
    expected = np.full(scene.COUNT, scene.EXPECTED)
    return plain_log_likelihood(scene.readings(), expected, model.sigma, 12.0, model.shares, model.rate)


@pytest.mark.parametrize("model", MODELS)
def test_likelihood_causes_and_a_round_are_those_of_the_reference(model: BeamModel) -> None:
    z, expected = scene.readings(), np.full(scene.COUNT, scene.EXPECTED)
    given = {"z": start("faisceau")["data"]["read"], "m": wire(model)}
    found, causes, after = script().value("[logLikelihood(z, 5, m), causes(z, 5, m), round(z, 5, m)]", **given)
    assert found == pytest.approx(told(model), rel=1e-10)
    np.testing.assert_allclose(np.array(causes).T, plain_responsibilities(model, z, expected), atol=1e-12)
    other = plain_em_round(model, z, expected)
    np.testing.assert_allclose([*after["shares"], after["sigma"], after["rate"]],
                               [*other.shares, other.sigma, other.rate], rtol=1e-9)  # fmt: skip


def test_a_range_that_is_impossible_stops_em() -> None:
    model = wire(BeamModel(12.0, 1.0, 0.0, 0.0, 0.0, 0.05, 1.0))
    given = {"z": [1.0, 5.0], "m": model}
    found = script().value("[logLikelihood(z, 5, m) === -Infinity, round(z, 5, m), settle(z, 5, m).rounds]", **given)
    assert found == [True, None, 0]


def test_every_reading_is_in_one_bar() -> None:
    z = start("faisceau")["data"]["read"]
    bars = script().value("histogram(z, 12, 0.25)", z=z)
    assert sorted(k for bar in bars for k in bar) == list(range(scene.COUNT))
    assert {z[k] for k in bars[-1]} == {12.0}
    assert all(0.25 * i <= z[k] < 0.25 * (i + 1) for i, bar in enumerate(bars[:-1]) for k in bar)


def test_what_the_page_says_of_the_fit() -> None:
    text = (FOLDER.parent / "cours" / "telemetre.md").read_text(encoding="utf-8").replace("$", "")
    z, begun = start("faisceau")["data"]["read"], start("faisceau")["values"]
    names = ("hit", "short", "beyond", "random")
    first = {"shares": [begun[name] for name in names], "sigma": begun["sigma"], "rate": begun["rate"], "reach": 12.0}
    call = """[logLikelihood(z, 5, m), logLikelihood(z, 5, round(z, 5, m)), settle(z, 5, m).model,
               logLikelihood(z, 5, settle(z, 5, m).model)]"""
    before, once, settled, after = script().value(call, z=z, m=first)
    for number in (before, once, after):
        assert f"−{-number:.1f}".replace(".", ",") in text
    sure = {**first, "shares": [1 / 3, 1 / 3, 1 / 3, 0.0]}
    *_, wide, low = script().value(call, z=z, m=sure)
    assert wide["shares"][3] == 0.0
    assert f"{wide['sigma']:.2f} case au lieu de {settled['sigma']:.2f}".replace(".", ",") in text
    assert f"−{-low:.1f} au lieu de −{-after:.1f}".replace(".", ",") in text
    assert sum(5.9 < one < 12.0 for one in z) == 19
    assert "dix-neuf lectures entre 5,9 et 12 cases" in text
    by_hand = {"shares": [0.6, 0.2, 0.08, 0.12], "sigma": 0.35, "rate": 1.0, "reach": 12.0}
    assert script().value("logLikelihood(z, 5, m)", z=z, m=by_hand) > -630.0, "the hand gets there"
