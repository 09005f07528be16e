"""l20/noeud_ros: honest nodes pass, each mistake is named, what is shown is small and draws."""

from __future__ import annotations

import json
from functools import partial

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import UnreadableError, Value
from graders.l20.noeud_ros import cases
from graders.l20.noeud_ros.judge import Did, read_log, right
from graders.l20.noeud_ros.scenes import JUDGED, Phase, must_stop, phase
from graders.plotting import counterexample
from server.base.files import ROOT as PROJECT
from tests.support.quick import THEMES, one_in, some
from tests.support.shipped import CODE
from tests.support.verdicts import checked, failed, named, verdict_of

GRADER = CODE["l20/noeud_ros"]
verdict = partial(verdict_of, GRADER.exercise)
MISTAKES = {mistake.id: mistake for mistake in GRADER.misconceptions}
OK = sorted((PROJECT / "graders/l20/noeud_ros/specimens/ok").glob("*.py"))

NODE = """
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

class ArretUrgence(Node):
    def __init__(self):
        super().__init__("a")
        self.declare_parameter("distance_min", 0.3)
        self.vitesses = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.recevoir, 10)

    def recevoir(self, scan):
        n = len(scan.ranges)
        seuil = self.get_parameter("distance_min").value
        devant = scan.ranges[n // 2 - 10 : n // 2 + 10]
        valides = [d for d in devant if scan.range_min < d < scan.range_max]
        if valides and min(valides) < seuil:
            self.vitesses.publish(Twist())
"""
WINDOW = "scan.ranges[n // 2 - 10 : n // 2 + 10]"
VALID = "[d for d in devant if scan.range_min < d < scan.range_max]"
TEST = "if valides and min(valides) < seuil:"


def test_the_solution_has_full_marks() -> None:
    assert verdict(GRADER.solution, 0).outcome is Outcome.OK


def test_the_starter_has_none() -> None:
    starter = (PROJECT / "curriculum/l20/exercices/noeud_ros/starter.py").read_text(encoding="utf-8")
    found = checked(GRADER.exercise, starter, 0).verdict
    assert found.score == 0.0
    assert "n'est pas abonné à /scan" in found.checks[0].message


@pytest.mark.parametrize("path", OK[::5], ids=lambda path: path.stem)
def test_honest_styles_pass(path: object) -> None:
    source = path.read_text(encoding="utf-8")  # type: ignore[attr-defined]
    found = verdict(source, 3)
    assert found.outcome is Outcome.OK, failed(found)


@pytest.mark.slow
@pytest.mark.parametrize("path", OK, ids=lambda path: path.stem)
def test_honest_styles_pass_at_every_seed(path: object) -> None:
    source = path.read_text(encoding="utf-8")  # type: ignore[attr-defined]
    assert {verdict(source, seed).outcome for seed in range(30)} == {Outcome.OK}


@pytest.mark.slow
@pytest.mark.parametrize("name", MISTAKES)
def test_a_known_mistake_is_rejected_and_named(name: str) -> None:
    found = verdict(MISTAKES[name].source, 2)
    assert found.outcome is Outcome.WRONG_ANSWER
    assert named(found) == name


@pytest.mark.parametrize(
    ("name", "old", "new"),
    one_in(
        3,
        [
            ("tout_le_scan", WINDOW, "scan.ranges"),
            ("fenetre_en_dur", WINDOW, "scan.ranges[170:190]"),
            ("un_seul_cote", WINDOW, "scan.ranges[n // 2 : n // 2 + 10]"),
            ("fenetre_trop_etroite", WINDOW, "[scan.ranges[n // 2]]"),
            ("fenetre_trop_large", WINDOW, "[d for k, d in enumerate(scan.ranges) if abs(k - n / 2) <= 20]"),
            ("range_max_oublie", VALID, "[d for d in devant if d > scan.range_min]"),
            (
                "nan_dans_le_minimum",
                f"valides = {VALID}",
                "valides = [min(devant)] if min(devant) < scan.range_max else []",
            ),
            ("nan_declenche", VALID, "[0.1 if d != d else d for d in devant if not (d > scan.range_max)]"),
            ("tous_les_rayons", TEST, "if valides and max(valides) < seuil:"),
            ("moyenne", TEST, "if valides and np.mean(valides) < seuil:"),
            ("comparaison_inversee", TEST, "if not (valides and min(valides) < seuil):"),
            ("toujours_l_arret", TEST, "if True:"),
            ("seuil_en_dur", TEST, "if valides and min(valides) < 0.3:"),
            ("defaut_faux", '"distance_min", 0.3', '"distance_min", 1.0'),
            ("lancement_ignore", '"distance_min", 0.3)', '"distance_min", 0.3, ignore_override=True)'),
            ("invalide_fait_taire", TEST, "if len(valides) == 20 and min(valides) < seuil:"),
            ("centimetres", TEST, "if valides and min(valides) * 100 < seuil:"),
            ("autre_topic_d_entree", '"/scan"', '"/lidar"'),
            ("autre_topic_de_sortie", '"/cmd_vel"', '"~/cmd_vel"'),
            ("mauvais_type", "create_publisher(Twist", "create_publisher(TwistStamped"),
        ],
    ),
)
def test_a_mistake_is_recognised_in_another_style(name: str, old: str, new: str) -> None:
    assert NODE.count(old) == 1
    source = NODE.replace(old, new)
    if name == "mauvais_type":
        source = source.replace("publish(Twist())", "publish(TwistStamped())")
    assert named(verdict(source, 0)) == name


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("self.vitesses.publish(Twist())", "pass"),
        ("self.vitesses.publish(Twist())", "self.vitesses.publish(0.0)"),
        ("n = len(scan.ranges)", "n = str(scan.ranges)"),
        ("ArretUrgence(Node)", "ArretUrgence"),
    ],
)
def test_silence_and_exceptions_that_many_mistakes_explain_have_no_name(old: str, new: str) -> None:
    found = verdict(NODE.replace(old, new), 0)
    assert found.score == 0.0
    assert named(found) is None


@pytest.mark.parametrize(
    ("old", "new", "where"),
    one_in(
        2,
        [
            (WINDOW, "scan.ranges[n // 2 - 13 : n // 2 + 13]", {"fenetre"}),
            (WINDOW, "scan.ranges[n // 2 - 7 : n // 2 + 7]", {"fenetre"}),
            (WINDOW, "scan.ranges[(n - 28) // 2 : (n + 12) // 2]", {"fenetre"}),
            (VALID, "np.nan_to_num(devant)", {"lectures"}),
            (VALID, "[d for d in devant if d < scan.range_max]", set()),
            ("< seuil", "< seuil - 0.05", {"exemples"}),
            ("< seuil", "< seuil + 0.05", {"exemples"}),
            ("< seuil", "< min(seuil, 0.6)", {"reglage"}),
            ("< seuil", "< max(seuil, 0.2)", {"reglage"}),
        ],
    ),
)
def test_what_is_subtly_wrong_is_rejected(old: str, new: str, where: set[str]) -> None:
    """But for readings up to range_min, which are not judged."""
    found = failed(checked(GRADER.exercise, NODE.replace(old, new), 0).verdict)
    assert where <= found
    assert where or not found


def test_a_parameter_of_another_name_is_told_as_absent() -> None:
    assert named(verdict(NODE.replace("distance_min", "distance_mini"), 0)) == "parametre_absent"


def test_a_node_that_cannot_be_made_has_the_name_of_no_two_mistakes() -> None:
    assert named(verdict(NODE.replace("self.recevoir, 10", "self.recevoir(), 10"), 0)) is None


def test_a_narrow_window_has_the_same_mark_at_every_seed() -> None:
    narrow = NODE.replace(WINDOW, "scan.ranges[n // 2 - 5 : n // 2 + 5]")
    assert {frozenset(failed(verdict(narrow, seed))) for seed in range(3)} == {frozenset({"fenetre"})}


def test_a_range_max_of_ten_metres_is_not_supposed() -> None:
    found = checked(GRADER.exercise, NODE.replace("scan.range_max", "10.0"), 0).verdict
    assert failed(found) == {"lectures"}


def test_every_scene_is_judged_alike_by_every_reading_of_the_contract() -> None:
    for seed in range(5):
        for drawing in cases.EVERY:
            for scene in some(drawing(np.random.default_rng(seed))):
                assert all(cases.fair(one) for one in scene.phases)
                assert {one.stop for one in scene.phases} == {True, False}


@pytest.mark.parametrize(
    ("near", "distance", "stop"), [(0.2, 0.3, True), (0.2, 0.15, False), (float("nan"), 0.3, False), (0.4, 0.3, False)]
)
def test_the_table_of_the_statement(near: float, distance: float, stop: bool) -> None:
    ranges = cases.beams(36, {18: near})
    assert must_stop(ranges, distance, 0.05, 10.0) is stop
    assert not must_stop(cases.beams(36, {2: near}), distance, 0.05, 10.0)


def test_the_first_counterexample_is_one_situation_alone() -> None:
    found = checked(GRADER.exercise, MISTAKES["nan_declenche"].source, 0, simplified=True).verdict
    check = next(one for one in found.checks if not one.passed)
    assert check.counterexample is not None
    assert check.counterexample.inputs.keys() >= {"scan.ranges", "distance_min"}
    assert (check.counterexample.expected, check.counterexample.got) == (
        "rien sur /cmd_vel",
        "un Twist nul sur /cmd_vel",
    )
    assert "situation n°" not in check.message
    source = MISTAKES["arret_verrouille"].source
    latched = checked(GRADER.exercise, source, 0, simplified=True).verdict.checks[0]
    assert "situation n° 3 de la même vie" in latched.message


def test_an_exception_is_shown_on_the_scan_that_calls_for_it() -> None:
    source = NODE.replace(TEST, "if min(valides) < seuil:")
    found = checked(GRADER.exercise, source, 0, simplified=True).verdict
    check = next(one for one in found.checks if one.id == "lectures")
    assert check.counterexample is not None
    assert "La même erreur que pour" in check.message
    assert sum("ValueError" in one.message for one in found.checks) == 1
    assert check.counterexample.inputs["scan.ranges"]


def test_a_refused_setting_is_told() -> None:
    found = checked(GRADER.exercise, MISTAKES["reglage_refuse"].source, 0).verdict
    message = next(c.message for c in found.checks if c.id == "reglage")
    assert "a refusé le nouveau réglage" in message


@pytest.mark.parametrize("theme", THEMES)
def test_figures_draw(theme: str) -> None:
    figures = checked(GRADER.exercise, MISTAKES["nan_declenche"].source, 1).figures
    for data in some(json.loads(json.dumps(figures)).values()):
        assert counterexample(GRADER.exercise, data, theme=theme).startswith(b"<?xml")


@pytest.mark.parametrize(
    "value",
    [None, 3, [], {"publications": 3}, {"publications": [{"topic": "/cmd_vel"}]}, {"abonnements": [1, [2, 3], "x"]},
     {"publications": [{"topic": "/cmd_vel", "type": "geometry_msgs/msg/Twist", "t": [0.0], "valeurs": [[1.0]]}]},
     {"publications": [{"topic": np.zeros(3), "type": np.ones((2, 2)), "t": 3}]},
     {"abonnements": [np.zeros((2, 2)), [np.zeros(3), {}]], "reglages": [{"t": np.zeros(2), "accepte": np.ones(2)}]},
     {"reglages": [{"t": [1], "accepte": 3}, {"t": 1.0, "accepte": False, "raison": [9] * 999}]}],
)  # fmt: skip
def test_any_log_is_read_or_refused(value: Value) -> None:
    try:
        log = read_log(value)
    except UnreadableError:
        return
    assert log.did(0, JUDGED) is Did.NOTHING
    assert all(len(reason) <= 200 for reason in log.refused)


def test_settling_is_forgiven_and_silence_is_not() -> None:
    assert [right(did, stop=True) for did in Did] == [False, True, True, False]
    assert [right(did, stop=False) for did in Did] == [True, False, True, False]
    assert isinstance(phase([1.0] * 30, ""), Phase)
