"""What a student's program did can be watched beside the reference: each film of a grading becomes a replay that the
player can show, and marks the step where a wrong program parts from it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

from graders.core.code.runner import Runner
from graders.core.code.running import run_checks
from graders.core.contract.bounds import json_size
from graders.core.contract.films import film_to_json
from graders.core.contract.local import LOCAL
from graders.core.contract.streams import stream
from graders.l20.predire2d.cases import module_world
from graders.l20.predire2d.trials import SIGMA, WALKS, episodes, film
from graders.scene.films import wire
from reference.localisation.grid_filter import correct, predict
from server.base.files import ROOT as PROJECT
from server.figures.program import MAX_REPLAY_BYTES
from tests.support.quick import only, some
from tests.support.replays import layer, unpacked
from tests.support.shipped import CODE

FILMED = sorted(path.parent.name for path in some((PROJECT / "graders/l20").glob("*/replays.py")))
#: Bytes of one film that a program of the course leaves: all those of a grading have to fit into their bound.
USUAL = 60_000
#: Here something parts from the reference in every run that fails; elsewhere a run may fail by its end alone.
COMPARED = {"predire2d", "slam_graphe"}


@dataclass(frozen=True)
class Filmed:
    """What the checks of an exercise found of a program, without its diagnosis, and the films that they left."""

    exercise: str
    films: dict[str, Any]
    titles: dict[str, str]
    failed: frozenset[str]

    @property
    def scenes(self) -> dict[str, dict[str, Any]]:
        return {check: wire(self.exercise, film, self.titles[check]) for check, film in self.films.items()}


def run(exercise: str, source: str, seed: int = 1) -> Filmed:
    grader = CODE[f"l20/{exercise}"]
    kit = grader.kit(stream(seed, "kit"))
    runner = Runner(LOCAL, source.encode(), kit, budget=grader.budget)
    findings = run_checks(grader.checks, runner, kit, seed)
    runner.close()
    films = {check: film for check, data in runner.films.items() if (film := film_to_json(data))}
    assert films.keys() == runner.films.keys()
    results = [finding.result for finding in findings]
    failed = frozenset(one.id for one in results if not one.passed)
    return Filmed(grader.exercise, films, {one.id: one.title for one in results}, failed)


@cache
def solution(exercise: str) -> Filmed:
    return run(exercise, CODE[f"l20/{exercise}"].solution)


def mistaken(exercise: str, mistake: str) -> Filmed:
    return run(exercise, next(m.source for m in CODE[f"l20/{exercise}"].misconceptions if m.id == mistake))


@pytest.mark.parametrize("exercise", only(COMPARED, FILMED))
def test_a_right_program_can_be_watched_and_parts_from_nothing(exercise: str) -> None:
    for check, scene in some(solution(exercise).scenes.items()):
        body = json.dumps(scene, allow_nan=False)
        assert json_size(solution(exercise).films[check]) <= USUAL, check
        assert len(body) <= MAX_REPLAY_BYTES, check
        assert scene["parameters"] == [], check
        assert len(scene["alt"]) > 60, check
        assert scene["summary"], check
        assert "wrong" not in scene, check


@pytest.mark.slow
@pytest.mark.parametrize("exercise", FILMED)
def test_every_mistake_can_be_watched(exercise: str) -> None:
    for mistake in CODE[f"l20/{exercise}"].misconceptions:
        filmed = run(exercise, mistake.source)
        for check, scene in filmed.scenes.items():
            assert len(json.dumps(scene, allow_nan=False)) <= MAX_REPLAY_BYTES, (mistake.id, check)
            if exercise in COMPARED and check in filmed.failed:
                assert "wrong" in scene, (mistake.id, check)


def test_a_filter_that_forgets_its_belief_is_caught_where_it_first_matters() -> None:
    (scene,) = mistaken("predire2d", "croyance_oubliee").scenes.values()
    wrong, label = scene["wrong"]
    assert "corriger2d : le scan lit" in scene["frames"][wrong]["caption"].replace("\u00a0", " ")
    assert "s’écarte" in label
    assert len(scene["frames"]) == 17
    assert "le robot est perdu" in scene["summary"][-1].replace("\u00a0", " ")
    (chart,) = scene["charts"]
    assert chart["marks"][0]["x"] == wrong / 2
    assert scene["panels"] == ["Votre croyance", "Celle de la référence"]


@pytest.mark.parametrize("count", [0, 1, 7, 16])
def test_a_walk_is_shown_as_far_as_the_program_went(count: int) -> None:
    grid, episode = module_world(), episodes(WALKS)[0]
    belief, beliefs = grid.uniform_belief(), []
    for command, cell in zip(episode.commands, episode.cells, strict=True):
        belief = predict(grid, belief, *command)
        beliefs.append(belief)
        belief = correct(grid, belief, grid.scans[cell], SIGMA)
        beliefs.append(belief)
    scene = wire("l20/predire2d", film(episode, beliefs[:count]), "Suivre")
    whole = count == len(beliefs)
    assert len(scene["frames"]) == count + (1 if whole else 2)
    assert ("wrong" in scene) != whole
    if not whole:
        assert scene["wrong"][0] == count + 1
        assert "n’a pas renvoyé de croyance" in scene["frames"][-1]["caption"]
    for frame in scene["frames"][:-1]:
        mine, theirs = ([one for one in frame["layers"] if one.get("panel") == panel] for panel in (0, 1))
        assert [one["kind"] for one in mine] == [one["kind"] for one in theirs], "right so far"


@pytest.mark.parametrize("belief", [np.zeros, lambda shape: -np.ones(shape), partial(np.full, fill_value=1e300)])
def test_beliefs_that_are_none_are_shown_too(belief: Any) -> None:
    grid, episode = module_world(), episodes(WALKS)[0]
    data = film(episode, [belief(grid.free.shape)] * 16)
    assert wire("l20/predire2d", data, "Suivre")["wrong"][0] == 1


def test_a_graph_that_diverges_is_caught_at_the_iteration_where_chi2_climbs() -> None:
    filmed = mistaken("slam_graphe", "signe_du_pas")
    scene = filmed.scenes["boucle"]
    wrong, _ = scene["wrong"]
    assert wrong == 1
    assert "χ² monte" in scene["frames"][wrong]["caption"].replace("\u00a0", " ")
    theirs = [one for one in scene["frames"][-1]["layers"] if one.get("panel") == 1]
    assert len(unpacked(layer(theirs, "points")["at"])) == len(filmed.films["boucle"]["start"])


def test_nothing_more_is_asked_of_a_program_whose_graphs_are_right() -> None:
    films = solution("slam_graphe").films
    assert films.keys() == {"chaine", "boucle", "poids", "demi_tour", "grande_boucle"}
    assert all(film["steps"] == [] and film["right"] for film in films.values())


def test_a_program_that_gives_no_poses_is_shown_as_such() -> None:
    scene = run("slam_graphe", "def gauss_newton(poses, aretes, n_iter=10):\n    return 1 / 0\n").scenes["chaine"]
    assert scene["wrong"][0] == len(scene["frames"]) - 1 == 1
    assert "ne renvoie pas de poses" in scene["summary"][-1]
