"""Replays 2 and 3: beliefs are beliefs, N_eff is between 1 and N, and what happens later changes nothing before."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.localisation.grid_filter import GridFilterError, GridWorld, possible_landings, predict, sample_move
from tests.support.quick import some
from tests.support.replays import cells, layer, scene, unpacked

BYTE = 1 / 255


@given(st.sampled_from([(1, 0), (-1, 0), (0, 1), (0, -1)]), st.floats(0.0, 0.5), st.integers(0, 2**32 - 1))
def test_a_slip_of_any_size_leaves_a_belief(command: tuple[int, int], slip: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    world = GridWorld.from_free_cells(rng.random((5, 6)) > 0.3, 12.0)
    belief = world.uniform_belief()
    assert np.isclose(sum(one.probability for one in possible_landings(*command, slip)), 1.0)
    moved = predict(world, belief, *command, slip=slip)
    assert np.isclose(moved.sum(), 1.0)
    cell = tuple(np.argwhere(world.free)[0].tolist())
    assert world.is_free(sample_move(world, cell, *command, rng, slip=slip))


@pytest.mark.parametrize("slip", [-0.1, 0.6, np.nan])
def test_a_slip_that_is_none_is_refused(slip: float) -> None:
    with pytest.raises(GridFilterError, match="slip"):
        possible_landings(1, 0, slip)


@pytest.mark.parametrize("settings", [{}, {"depart": "jumelles"}, {"sigma": 3}, {"glissement": 0.3, "portee": 2}])
def test_each_picture_of_the_grid_filter_is_a_belief_on_free_cells(settings: dict[str, Any]) -> None:
    body = scene("filtre-grille", **settings)
    walls = cells(layer(body["layers"], "grid")) > 0.5
    of_truth, greatest = (
        next(one["y"] for one in body["charts"][0]["series"] if one["color"] == color)
        for color in ("truth", "estimate")
    )
    for k, frame in some(enumerate(body["frames"])):
        belief = cells(layer(frame["layers"], "grid")) ** 2
        assert belief[walls].max() == 0.0
        # Each square root is known to half a byte.
        assert abs(belief.sum() - 1.0) < BYTE * np.sqrt(belief).sum() + 0.01
        x, y, _ = layer(frame["layers"], "pose")["at"]
        assert not walls[int(y), int(x)]
        assert abs(belief[int(y), int(x)] - of_truth[k]) < 0.01
        assert abs(belief.max() - greatest[k]) < 0.01


def test_twin_rooms_keep_two_bumps_until_the_corridor_tells_them_apart() -> None:
    body = scene("filtre-grille", depart="jumelles", sigma=0.6, glissement=0)
    halves = []
    for frame in body["frames"][1:]:
        belief = cells(layer(frame["layers"], "grid")) ** 2
        halves.append(belief[:, :12].sum() / belief.sum())
    assert 0.4 < halves[4] < 0.6
    assert max(halves[-1], 1.0 - halves[-1]) > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("settings", [{}, {"particules": 20}, {"seuil": 0}, {"seuil": 1}, {"enlevement": 14}])
def test_the_cloud_keeps_its_number_and_its_effective_size_its_bounds(settings: dict[str, Any]) -> None:
    body = scene("mcl", **settings)
    count = int(settings.get("particules", 500))
    sizes = np.array(body["charts"][0]["series"][0]["y"])
    assert np.all((sizes >= 0.999) & (sizes <= count + 0.5))
    moments = body["charts"][0]["cursor"]
    assert moments == sorted(moments)
    for frame in body["frames"]:
        cloud = layer(frame["layers"], "points")
        if "at" in cloud:
            assert len(unpacked(cloud["at"])) == len(unpacked(cloud["headings"])) == count
        else:
            weights = unpacked(cloud["weights"])
            assert weights.shape == (count,)
            assert weights.min() >= 0.0
            assert weights.max() == pytest.approx(1.0)


def test_the_first_picture_gives_all_its_points() -> None:
    assert "at" in layer(scene("mcl")["frames"][0]["layers"], "points")


def test_the_threshold_rules_resampling() -> None:
    drawn = {
        seuil: sum("rééchantillonnage" in frame["caption"] for frame in scene("mcl", seuil=seuil)["frames"])
        for seuil in (0, 0.5, 1)
    }
    assert drawn[0] == 0
    assert 0 < drawn[0.5] < drawn[1] == 47


def test_kidnapping_changes_nothing_of_what_came_before_and_is_noticed() -> None:
    plain, taken = scene("mcl"), scene("mcl", enlevement=14)
    before = [frame for frame in taken["frames"] if frame["step"] < 14]
    assert before == plain["frames"][: len(before)]
    assert taken["frames"] != plain["frames"]
    usual, carried = (np.array(body["charts"][1]["series"][0]["y"]) for body in (plain, taken))
    assert carried[14] > 3.0
    assert usual[14] < 1.0
    assert "Enlevé au pas 14" in " ".join(taken["summary"])


def test_enough_particles_find_the_robot() -> None:
    for draw in (1, 2, 6):
        assert scene("mcl", tirage=draw)["charts"][1]["series"][0]["y"][-1] < 1.0
