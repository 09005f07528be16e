"""The simulated ROS 2: messages, parameters, topics, timers, spin, as rclpy has them."""

from __future__ import annotations

import array
import math
from typing import Any

import pytest

from server.base.files import ROOT as PROJECT
from tests.support.ros import Ros, ros

SIMULATED = ros()
NODE = """
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult, FloatingPointRange
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Float32, Float64, Header, String
node = Node("noeud", **OPTIONS)
"""


def program(code: str = "", *, seconds: float = 0.0, **options: Any) -> dict[str, Any]:
    SIMULATED.begun(seconds).names["OPTIONS"] = options
    return SIMULATED.run(NODE, code)


def failure(code: str, **options: Any) -> str:
    """The exception that it raises, with its message."""
    with pytest.raises(Exception) as caught:  # noqa: PT011 (which one is what is looked at)
        program(code, **options)
    return f"{type(caught.value).__name__}: {caught.value}"


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("Twist().linear.x = 0", "AssertionError: The 'x' field must be of type 'float'"),
        ("Float32(data=1)", "AssertionError: The 'data' field must be of type 'float'"),
        ("Float32(data=1e39)", "AssertionError: The 'data' field must be a float in [-3.402823466e+38"),
        ("Twist().linear = 0.0", "AssertionError: The 'linear' field must be a sub message of type 'Vector3'"),
        ("Twist(vitesse=1.0)", "AssertionError: Invalid arguments passed to constructor: vitesse"),
        ("Twist(Vector3())", "TypeError"),
        ("Twist().vitesse = 1.0", "AttributeError: 'Twist' object has no attribute 'vitesse'"),
        ("String(data=3)", "AssertionError: The 'data' field must be of type 'str'"),
        ("Bool(data=1)", "AssertionError: The 'data' field must be of type 'bool'"),
        ("LaserScan(ranges=[1, 2])", "AssertionError: The 'ranges' field must be a set or sequence and each value of"),
        ("LaserScan(ranges='12')", "AssertionError: The 'ranges' field must be"),
        ("Header().stamp.nanosec = -1", "AssertionError: The 'nanosec' field must be an unsigned integer in [0, 42"),
        ("Header().stamp.sec = 1.5", "AssertionError: The 'sec' field must be of type 'int'"),
    ],
)
def test_messages_refuse_what_ros_refuses(code: str, expected: str) -> None:
    assert failure(code).startswith(expected)


def test_messages_hold_what_ros_holds() -> None:
    names = program(
        "scan = LaserScan(ranges=[0.2, math.inf], range_min=0.1) if (math := __import__('math')) else None\n"
        "same = Twist(linear=Vector3(x=1.0)) == Twist(linear=Vector3(x=1.0)) != Twist()\n"
        "text = repr(Vector3(x=1.0))\n"
        "fields = LaserScan.get_fields_and_field_types()\n"
    )
    scan = names["scan"]
    assert scan.ranges == array.array("f", [0.2, math.inf])
    assert scan.transporter().range_min == array.array("f", [0.1])[0] != scan.range_min == 0.1
    assert names["same"] is True
    assert names["text"] == "geometry_msgs.msg.Vector3(x=1.0, y=0.0, z=0.0)"
    assert names["fields"]["ranges"] == "sequence<float>"


@pytest.mark.parametrize(
    ("topic", "resolved"),
    [("scan", "/r2/scan"), ("/scan", "/scan"), ("~/scan", "/r2/noeud/scan"), ("a/b_1", "/r2/a/b_1")],
)
def test_names_of_topics_are_resolved(topic: str, resolved: str) -> None:
    names = program(f"p = node.create_publisher(Twist, {topic!r}, 10)", namespace="r2")
    assert names["p"].topic_name == resolved


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("Node('arrêt')", "InvalidNodeNameException"),
        ("node.create_publisher(Twist, '/cmd vel', 10)", "InvalidTopicNameException"),
        ("node.create_publisher(Twist, '/cmd_vel')", "TypeError"),
        ("node.create_publisher(Twist, '/cmd_vel', '10')", "TypeError: Expected QoSProfile or int"),
        ("node.create_publisher(Twist, '/cmd_vel', -1)", "ValueError"),
        ("node.create_publisher(Twist(), '/cmd_vel', 1)", "AttributeError"),
        ("node.create_publisher(Twist, '/cmd_vel', 1).publish(Vector3())", "TypeError: Expected <class"),
        ("node.create_publisher(Twist, '/cmd_vel', 1).publish(Twist)", "TypeError: Expected <class"),
        (
            "node.create_subscription(LaserScan, '/scan', lambda: 0, 1)",
            "RuntimeError: Subscription.__init__(): callback",
        ),
        ("node.create_subscription(LaserScan, '/scan', None, 1)", "RuntimeError: Subscription.__init__(): callback"),
        ("rclpy.init()", "RuntimeError: Context.init() must only be called once"),
        ("rclpy.shutdown(); rclpy.shutdown()", "RuntimeError: Context must be initialized before it can be shutdown"),
        ("rclpy.shutdown(); Node('x')", "NotInitializedException"),
        ("node.get_parameter('absent')", "ParameterNotDeclaredException: Invalid access to undeclared parameter(s)"),
        ("node.declare_parameter('a', 1.0); node.declare_parameter('a', 1.0)", "ParameterAlreadyDeclaredException"),
        ("node.declare_parameter('a', None, ParameterDescriptor())", "ValueError: Cannot declare a statically typed"),
        ("Node.__new__(Node).create_timer(1.0, print)", "AttributeError: 'Node' object has no attribute '_"),
    ],
)
def test_what_ros_refuses_is_refused(code: str, expected: str) -> None:
    assert failure(code).startswith(expected)


def test_a_double_refuses_an_integer_and_keeps_its_value() -> None:
    names = program(
        "node.declare_parameter('d', 0.3)\n"
        "results = node.set_parameters([Parameter('d', value=1), Parameter('d', value=0.5)])\n"
        "value = node.get_parameter('d').value, node.get_parameter('d').get_parameter_value().double_value\n"
    )
    refused, accepted = names["results"]
    assert (refused.successful, accepted.successful) == (False, True)
    assert refused.reason.startswith("Wrong parameter type, expected 'Type.DOUBLE' got 'Type.INTEGER'")
    assert names["value"] == (0.5, 0.5)
    assert "expecting type 'DOUBLE'" in failure("node.declare_parameter('d', 0.3)", parameter_overrides=[_integer()])


def _integer() -> Any:
    return SIMULATED.module("rclpy.parameter").Parameter("d", value=1)


def test_callbacks_see_refuse_and_follow_changes() -> None:
    names = program(
        "seen = []\n"
        "def during(parameters):\n"
        "    seen.append(['during', parameters[0].value, node.has_parameter('d') and node.get_parameter('d').value])\n"
        "    return SetParametersResult(successful=parameters[0].value < 1.0, reason='trop grand')\n"
        "node.declare_parameter('d', 0.3)\n"
        "node.add_on_set_parameters_callback(during)\n"
        "node.add_post_set_parameters_callback(lambda ps: seen.append(['after', node.get_parameter('d').value]))\n"
        "results = node.set_parameters([Parameter('d', value=0.5), Parameter('d', value=2.0)])\n"
    )
    assert names["seen"] == [["during", 0.5, 0.3], ["after", 0.5], ["during", 2.0, 0.5]]
    assert [result.successful for result in names["results"]] == [True, False]
    assert names["results"][1].reason == "trop grand"
    silent = "node.add_on_set_parameters_callback(lambda ps: None)\nnode.declare_parameter('d', 0.3)"
    assert failure(silent).startswith("AttributeError: 'NoneType' object has no attribute 'successful'")


def test_descriptors_bound_and_freeze() -> None:
    names = program(
        "limits = FloatingPointRange(from_value=0.0, to_value=1.0)\n"
        "node.declare_parameters('frein', [('d', 0.5, ParameterDescriptor(floating_point_range=[limits]))])\n"
        "node.declare_parameter('fixe', 1.0, ParameterDescriptor(read_only=True))\n"
        "asked = [('frein.d', 1.5), ('frein.d', 1.0), ('fixe', 2.0)]\n"
        "results = [node.set_parameters([Parameter(n, value=v)])[0].successful for n, v in asked]\n"
    )
    assert names["results"] == [False, True, False]


def test_time_is_simulated_and_spin_comes_back_when_nothing_can_happen() -> None:
    names = program(
        "ticks = []\n"
        "begun = node.get_clock().now()\n"
        "timer = node.create_timer(0.25, lambda: ticks.append((node.get_clock().now() - begun).nanoseconds / 1e9))\n"
        "rclpy.spin(node)\n"
        "over = rclpy.ok()\n"
        "rclpy.shutdown()\n",
        seconds=1.1,
    )
    assert names["ticks"] == [0.25, 0.5, 0.75, 1.0]
    assert names["over"] is False


@pytest.mark.parametrize("timeout", ["0.1", "0", "None"])
def test_a_loop_of_spin_once_ends(timeout: str) -> None:
    names = program(
        f"n = 0\nwhile rclpy.ok():\n    rclpy.spin_once(node, timeout_sec={timeout})\n    n += 1\n", seconds=0.5
    )
    assert 1 <= names["n"] <= 501
    assert "ExternalShutdown" in failure("rclpy.shutdown()\nrclpy.spin_once(node)")


def test_messages_go_from_a_node_to_another_as_copies_of_the_right_type() -> None:
    names = program(
        "got, late = [], []\n"
        "other = rclpy.create_node('autre')\n"
        "spoil = lambda m: (got.append(m.linear.x), setattr(m.linear, 'x', 9.0))\n"
        "other.create_subscription(Twist, 'cmd_vel', spoil, 10)\n"
        "other.create_subscription(Twist, '/cmd_vel', lambda m: late.append(m.linear.x), 1)\n"
        "other.create_subscription(Bool, '/cmd_vel', lambda m: got.append('bool'), 10)\n"
        "sent = Twist()\n"
        "pub = node.create_publisher(Twist, '/cmd_vel', 10)\n"
        "for x in (1.0, 2.0):\n"
        "    sent.linear.x = x\n"
        "    pub.publish(sent)\n"
        "counts = pub.get_subscription_count(), node.count_publishers('/cmd_vel')\n"
        "rclpy.spin(other)\n"
    )
    assert names["got"] == [1.0, 2.0]
    assert names["late"] == [2.0], "a queue of one keeps the last"
    assert names["counts"] == (3, 1)


def test_the_journal_throttles_each_line(capsys: pytest.CaptureFixture[str]) -> None:
    program(
        "log = node.get_logger()\n"
        "def tick():\n"
        "    log.info('souvent')\n"
        "    log.warning('rarement', throttle_duration_sec=0.45)\n"
        "    log.error('une fois', once=True)\n"
        "    log.debug('jamais')\n"
        "node.create_timer(0.1, tick)\n"
        "rclpy.spin(node)\n",
        seconds=1.0,
    )
    said = capsys.readouterr().err
    assert [said.count(word) for word in ("souvent", "rarement", "une fois", "jamais")] == [10, 2, 1, 0]
    assert said.startswith("[INFO] [1000.100000000] [noeud]: souvent\n")


def test_what_is_launched_with_a_value_starts_with_it() -> None:
    SIMULATED.begun().world.parametres_donnes["d"] = 0.6
    names = SIMULATED.run(NODE.replace("**OPTIONS", ""), "value = node.declare_parameter('d', 0.3).value")
    assert names["value"] == 0.6


def test_any_quality_of_service_is_understood() -> None:
    names = program(
        "from rclpy.qos import *\n"
        "from rclpy.qos import qos_profile_sensor_data, QoSProfile, ReliabilityPolicy, QoSPresetProfiles\n"
        "asked = [0, 10, qos_profile_sensor_data, QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)]\n"
        "asked += [QoSPresetProfiles.SENSOR_DATA.value, QoSProfile(history=HistoryPolicy.KEEP_ALL)]\n"
        "subs = [node.create_subscription(LaserScan, '/scan', print, qos) for qos in asked]\n"
    )
    assert len(names["subs"]) == 6
    assert failure("from rclpy.qos import QoSProfile\nQoSProfile()").startswith("InvalidQoSProfileException")


def test_the_files_are_short_enough_to_be_read() -> None:
    files = [*(PROJECT / "curriculum" / "l20" / "kit" / "ros").rglob("*.py")]
    assert len(files) > 20
    assert max(len(file.read_text(encoding="utf-8").splitlines()) for file in files) < 300


def test_the_world_of_a_test_is_its_own() -> None:
    assert isinstance(SIMULATED, Ros)
    assert SIMULATED.begun().world.noeuds == []
