"""Manipulations: what their scripts compute is what `reference/` computes, and what their pages say is so."""

from __future__ import annotations

import itertools
import json
from functools import cache

import numpy as np
import pytest

from curriculum.l20.manipulations.carte import scene as own_map
from curriculum.l20.manipulations.ressorts import scene as springs
from graders.scene.hands import cells_text, spots_of
from graders.scene.parameters import RefusedError
from reference.pose_graph import (
    DCS,
    Huber,
    Kernel,
    PoseGraph,
    Switchable,
    edge_chi2,
    gauss_newton,
    marginal_covariances,
    robust_gauss_newton,
)
from reference.sensors.beam import plain_log_likelihood
from server.base.errors import Invalid, NotFound
from tests.content.replays.hand_scripts import FOLDER, REPLAYS, Script, start

NAMES = REPLAYS.manipulation_names("l20")
KERNELS: dict[str, Kernel] = {"huber": Huber(1.0), "dcs": DCS(10.0), "commutables": Switchable(10.0)}
FALSE = (6, 16)


@cache
def graph_script() -> Script:
    return Script("ressorts", "calcul.js")


def wire(graph: PoseGraph) -> list[dict[str, object]]:
    rows = zip(graph.i, graph.j, graph.z_i_j, graph.information, strict=True)
    return [{"i": int(i), "j": int(j), "z": z.tolist(), "information": w.diagonal().tolist()} for i, j, z, w in rows]


def with_a_false_one(graph: PoseGraph, fixed: tuple[int, ...] = (0,)) -> PoseGraph:
    edges = [*zip(graph.i, graph.j, graph.z_i_j, graph.information, strict=True)]
    false = (*FALSE, np.zeros(3), np.diag(springs.CLOSURE**-2.0))
    return PoseGraph.from_edges(graph.n_poses, [*edges, false], fixed=fixed)


@pytest.mark.parametrize("name", NAMES)
def test_what_a_manipulation_starts_from_is_small_and_tells_itself(name: str) -> None:
    body = start(name)
    assert len(json.dumps(body)) < 20_000
    assert len(body["title"]) <= 60
    assert len(body["alt"]) >= 100
    assert body["legend"]
    assert body["box"][0] < body["box"][2]
    assert "export function begin(bench" in REPLAYS.script("l20", name, "main.js")


def test_the_graph_costs_what_the_reference_says_wherever_its_poses_are() -> None:
    graph, odometry = springs.chain()
    graph = with_a_false_one(graph)
    rng = np.random.default_rng(0)
    for size in (0.0, 0.3, 3.0):
        poses = odometry + size * rng.normal(size=odometry.shape)
        found = graph_script().value("edgeChi2(edges, poses)", edges=wire(graph), poses=poses.tolist())
        np.testing.assert_allclose(found, edge_chi2(graph, poses), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kernel", ["aucun", *KERNELS])
@pytest.mark.parametrize("fixed", [(0,), (0, 11)])
def test_a_step_of_the_script_is_a_step_of_the_reference(kernel: str, fixed: tuple[int, ...]) -> None:
    graph, poses = springs.chain()
    graph = with_a_false_one(graph, fixed)
    for _ in range(3):
        call = f"step(edges, poses, KERNELS.{kernel}, {list(fixed)})"
        found = np.array(graph_script().value(call, edges=wire(graph), poses=poses.tolist()))
        if kernel == "aucun":
            expected = gauss_newton(graph, poses, max_iterations=1).poses
        else:
            expected = robust_gauss_newton(graph, poses, KERNELS[kernel], max_iterations=1).poses
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-8)
        poses = expected


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_kernel_of_the_script_is_that_of_the_reference(kernel: str) -> None:
    u = np.concatenate([[0.0], np.geomspace(1e-3, 1e6, 60), [1.0, 30.0]])
    found = graph_script().value(f"u.map((one) => [KERNELS.{kernel}.rho(one), KERNELS.{kernel}.weight(one)])", u=[*u])
    np.testing.assert_allclose(np.array(found).T, [KERNELS[kernel].rho(u), KERNELS[kernel].weight(u)], rtol=1e-12)


def test_what_the_page_says_of_the_springs() -> None:
    graph, odometry = springs.chain()
    text = (FOLDER.parent / "seances" / "slam.md").read_text(encoding="utf-8")
    relaxed = gauss_newton(graph, odometry)
    assert f"$\\chi^2 = {relaxed.chi2[0]:.0f}$" in text
    assert f"${relaxed.chi2[-1]:.1f}$".replace(".", "{,}") in text
    assert edge_chi2(graph, odometry)[-2:].sum() > 0.99 * relaxed.chi2[0], "almost all of it in the closures"
    false = with_a_false_one(graph)
    assert np.abs(gauss_newton(false, relaxed.poses).poses - relaxed.poses)[:, :2].max() > 2.0, "the whole graph bends"
    for kernel in (KERNELS["dcs"], KERNELS["commutables"]):
        held = robust_gauss_newton(false, relaxed.poses, kernel)
        assert held.weights[-1] < 0.5 < held.weights[:-1].min()
    assert robust_gauss_newton(false, relaxed.poses, KERNELS["huber"]).weights[-1] < 0.5
    far = robust_gauss_newton(graph, odometry, KERNELS["dcs"])
    assert far.weights[-2:].max() < 0.5, "from so far, DCS takes the true ones for false"


@pytest.mark.parametrize(
    ("n", "sigma", "bound", "gap"), [(2, 0.2, 0.01, 1.0), (20, 0.1, 0.1, -0.7), (100, 0.05, 0.1, 1.0)]
)
def test_the_elastic_chain_is_a_graph_of_poses_on_a_line(n: int, sigma: float, bound: float, gap: float) -> None:
    found = Script("elastique", "calcul.js").value(
        "chain(n, sigma, bound, gap)", n=n, sigma=sigma, bound=bound, gap=gap
    )
    stiff = 1e6
    link, closure = (np.diag([one**-2.0, stiff, stiff]) for one in (sigma, bound))
    edges = [(k, k + 1, [1.0, 0.0, 0.0], link) for k in range(n)]
    start_at = np.column_stack([np.arange(n + 1.0), np.zeros((n + 1, 2))])
    graph = PoseGraph.from_edges(n + 1, [*edges, (0, n, [n + gap, 0.0, 0.0], closure)])
    solved = gauss_newton(graph, start_at)
    np.testing.assert_allclose(found["shifts"], solved.poses[:, 0] - start_at[:, 0], atol=1e-9)
    np.testing.assert_allclose(found["chi2"], solved.chi2[-1], rtol=1e-6)
    deviations = np.sqrt([covariance[0, 0] for covariance in marginal_covariances(graph, solved.poses)[0]])
    np.testing.assert_allclose(found["closed"], deviations, atol=1e-6)
    np.testing.assert_allclose(found["open"], sigma * np.sqrt(np.arange(n + 1.0)), rtol=1e-12)
    assert found["each"] * n + found["left"] == pytest.approx(gap)


def test_the_example_of_the_theorem_is_found_again() -> None:
    found = Script("elastique", "calcul.js").value("chain(100, 0.05, 0.1, 1)")
    said = (found["each"], found["left"], found["open"][-1], found["closed"][-1], max(found["closed"]))
    assert [f"{1000 * one:.0f}" for one in said] == ["10", "38", "500", "98", "255"]


@cache
def walker_script() -> Script:
    return Script("passant", "calcul.js")


def read(place: tuple[float, float]) -> np.ndarray:
    data = start("passant")["data"]
    call = "ranges(d.true, d.angles, d.read, d.noise, place, d.radius)"
    return np.array(walker_script().value(call, d=data, place=place))


def preferred(place: tuple[float, float], sigma: float = 0.2) -> tuple[int, bool, bool]:
    """How many beams are stopped, and whether the Gaussian, then the mixture, prefer the true pose."""
    data, z = start("passant")["data"], read(place)
    model = {"sigma": sigma, "shares": [0.7, 0.1, 0.1, 0.1], "rate": data["rate"], "reach": data["reach"]}
    given = {"z": z.tolist(), "e": data["expected"], "model": model}
    plain, mixed = walker_script().value(
        "[e.map((x) => gaussian(z, x, model.sigma)), e.map((x) => mixture(z, x, model))]", **given
    )
    return int(np.sum(z != data["read"])), plain[0] > plain[1], mixed[0] > mixed[1]


def test_the_mixture_is_that_of_the_reference() -> None:
    data = start("passant")["data"]
    for place, sigma, random in (((11.4, 8.0), 0.2, 0.1), ((9.5, 8.3), 0.5, 0.02), ((20.0, 3.0), 1.0, 0.3)):
        shares = [0.8 - random, 0.1, 0.1, random]
        for expected in data["expected"]:
            model = {"sigma": sigma, "shares": shares, "rate": data["rate"], "reach": data["reach"]}
            found = walker_script().value("mixture(z, e, model)", z=read(place).tolist(), e=expected, model=model)
            told = plain_log_likelihood(read(place), expected, sigma, data["reach"], shares, data["rate"])
            assert found == pytest.approx(told, rel=1e-10)
            plain = walker_script().value("gaussian(z, e, s)", z=read(place).tolist(), e=expected, s=sigma)
            assert plain == pytest.approx(-np.sum((read(place) - expected) ** 2) / (2.0 * sigma**2), rel=1e-12)


def test_a_ray_stops_where_it_enters_the_walker() -> None:
    rng = np.random.default_rng(5)
    along = np.linspace(0.0, 12.0, 120_001)
    for _ in range(40):
        origin, centre, angle = rng.uniform(0, 6, 2), rng.uniform(0, 6, 2), rng.uniform(-np.pi, np.pi)
        inside = (
            np.hypot(*(origin[:, None] + along * np.array([[np.cos(angle)], [np.sin(angle)]]) - centre[:, None])) <= 0.5
        )
        told = walker_script().value("meets(o, a, c, 0.5)", o=origin.tolist(), a=angle, c=centre.tolist())
        assert (told is None) == (not inside.any()), "infinity has no JSON"
        if told is not None:
            assert told == pytest.approx(along[inside.argmax()], abs=2e-4)


def test_what_the_page_says_of_the_walker() -> None:
    assert preferred((11.4, 8.0)) == (1, True, True)
    assert preferred((10.9, 8.0)) == (3, False, True)
    assert preferred((9.6, 8.0))[1:] == (False, True)
    assert preferred((10.9, 8.0), sigma=1.0)[1:] == (False, True)


def test_the_cells_of_a_map_are_read_alike_on_both_sides() -> None:
    script, parameter = Script("carte", "cases.js"), own_map.PARAMETERS["cases"]
    rng = np.random.default_rng(2)
    for cells in (own_map.DRAWN, rng.random(own_map.DRAWN.shape) < 0.5):
        text = cells_text(cells)
        assert np.array_equal(parameter.cells(parameter.read(text)), cells)
        assert script.value("fromText(text, 216)", text=text) == cells.ravel().tolist()
        assert script.value("toText(cells)", cells=cells.ravel().tolist()) == text
    assert script.value("[fromText('', 216), fromText('g'.repeat(54), 216), fromText(null, 216)]") == [None] * 3
    line = script.value("between([2, 3], [9, 5])")
    assert line[0] == [2, 3]
    assert line[-1] == [9, 5]
    assert all(max(abs(a - c), abs(b - d)) <= 1 for (a, b), (c, d) in itertools.pairwise(line))


def film(name: str, *settings: tuple[str, str]) -> list[str]:
    script = REPLAYS.find_manipulation("l20", name)
    body = script.run(script.read(settings))
    assert 1 <= len(body["frames"]) <= 400
    assert len(json.dumps(body)) < 1_500_000
    return list(body["summary"])


def test_particles_that_one_places_find_the_robot_or_not() -> None:
    assert "Retrouvé" in " ".join(film("particules", ("endroits", "3.5,3.5,100")))
    assert "n’est pas retrouvé" in " ".join(film("particules", ("endroits", "20,12,100")))


@pytest.mark.parametrize(
    "text", ["3,3", "3,3,5;", "a,b,c", "99,3,5", "3,3,0", "3,3,999;3,3,999", ";".join(["3,3,5"] * 25)]
)
def test_places_that_cannot_be_are_refused(text: str) -> None:
    script = REPLAYS.find_manipulation("l20", "particules")
    with pytest.raises(Invalid):
        script.read([("endroits", text)])


def test_the_empty_text_is_no_place_and_what_is_no_place_is_refused() -> None:
    assert spots_of("") == []
    with pytest.raises(RefusedError):
        spots_of("1;2")


@pytest.mark.parametrize("cases", ["0" * 54, "f" * 54, cells_text(own_map.DRAWN)])
def test_a_filter_runs_in_any_map_that_can_be_drawn(cases: str) -> None:
    told = film("carte", ("lance", "1"), ("cases", cases), ("particules", "100"), ("robot", "1.2,1.2,0"))
    assert len(told) >= 2


def test_in_the_map_that_is_given_the_robot_finds_itself() -> None:
    assert "Retrouvé" in " ".join(film("carte", ("lance", "1")))


@pytest.mark.parametrize("cases", ["", "0" * 53, "0" * 55, "g" * 54, "A" * 54])
def test_what_is_no_map_is_refused(cases: str) -> None:
    with pytest.raises(Invalid):
        REPLAYS.find_manipulation("l20", "carte").read([("cases", cases)])


@pytest.mark.parametrize("file", ["scene.py", "../ressorts/main.js", "absent.js", "main.js/", ".js"])
def test_nothing_but_scripts_is_served(file: str) -> None:
    with pytest.raises(NotFound):
        REPLAYS.script("l20", "carte", file)


@pytest.mark.parametrize(("module", "name"), [("l20", "absente"), ("l20", ".."), ("..", "carte"), ("l20", "_filtre")])
def test_a_manipulation_that_is_not_there_is_not_found(module: str, name: str) -> None:
    with pytest.raises(NotFound):
        REPLAYS.find_manipulation(module, name)
