"""A run exported as a rosbag2, read back by `rosbags`, which shares no code with what wrote it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reference.formats.rosbag import RosbagError, export_rosbag
from reference.odometry import DifferentialDrive, Motion, dead_reckoning
from reference.se2 import compose
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar, SimulatedRun, simulate

START = 1_700_000_000_000_000_000


def a_run(lidar: SimulatedLidar | None = None, steps: int = 12) -> SimulatedRun:
    rng = np.random.default_rng(4)
    place = GridMap.from_free(np.pad(np.ones((38, 58), dtype=bool), 1), 0.1, (-1.0, 2.0, 0.3))
    start = place.poses_to_world([20.0, 20.0, 0.5])
    drive = DifferentialDrive(0.3, sigma=0.002)
    return simulate(
        place, [Motion(0.05, 0.1)] * steps, start, drive, lidar or SimulatedLidar.full_turn(36, 2.0, 0.01), rng, 0.2
    )


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[SimulatedRun, dict[str, list[tuple[int, Any]]]]:
    """The run, and the messages of each topic of its bag with their times."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    run, folder = a_run(), tmp_path_factory.mktemp("bag")
    bag = export_rosbag(run, START)
    Path(folder, "run.mcap").write_bytes(bag.mcap)
    Path(folder, "metadata.yaml").write_text(bag.metadata)
    store = get_typestore(Stores.ROS2_HUMBLE)
    found: dict[str, list[tuple[int, Any]]] = {}
    with rosbag2.Reader(folder) as reader:
        assert {connection.topic: connection.msgcount for connection in reader.connections} == bag.messages
        assert (reader.start_time, reader.message_count) == (START, sum(bag.messages.values()))
        assert reader.duration >= round(1e9 * run.times[-1])
        for connection, time, data in reader.messages():
            message = store.deserialize_cdr(data, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, message))
    return run, found


def planar(position: Any, orientation: Any) -> np.ndarray:
    assert position.z == orientation.x == orientation.y == 0.0
    return np.array([position.x, position.y, 2.0 * np.arctan2(orientation.z, orientation.w)])


def test_every_topic_speaks_at_every_pose(recorded: Any) -> None:
    run, found = recorded
    stamps = [START + round(1e9 * time) for time in run.times]
    assert set(found) == {"/scan", "/odom", "/ground_truth", "/tf"}
    for messages in found.values():
        assert [time for time, _ in messages] == stamps
    for stamp, message in found["/scan"] + found["/odom"]:
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp


def test_scans_are_those_of_the_lidar(recorded: Any) -> None:
    run, found = recorded
    assert np.any(run.ranges == 2.0)
    for (_, scan), ranges in zip(found["/scan"], run.ranges, strict=True):
        assert scan.header.frame_id == "laser"
        np.testing.assert_allclose(np.minimum(scan.ranges, 2.0), ranges, rtol=1e-6)
        assert np.array_equal(np.isinf(scan.ranges), ranges == 2.0)
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        np.testing.assert_allclose(angles, run.lidar.angles, atol=1e-5)
        assert scan.angle_max == pytest.approx(angles[-1], abs=1e-5)
        assert (scan.range_max, scan.scan_time) == (2.0, pytest.approx(0.2))


def test_odometry_and_truth_are_those_of_the_run(recorded: Any) -> None:
    run, found = recorded
    believed = dead_reckoning(run.drive, run.wheels, run.truth[0])
    for k in range(len(run)):
        odometry, truth = found["/odom"][k][1], found["/ground_truth"][k][1]
        assert (odometry.header.frame_id, truth.header.frame_id) == ("odom", "map")
        assert odometry.child_frame_id == truth.child_frame_id == "base_link"
        np.testing.assert_allclose(planar(odometry.pose.pose.position, odometry.pose.pose.orientation), run.odometry[k])
        np.testing.assert_allclose(planar(truth.pose.pose.position, truth.pose.pose.orientation), run.truth[k])
        S = np.reshape(odometry.pose.covariance, (6, 6))
        np.testing.assert_allclose(S[np.ix_([0, 1, 5], [0, 1, 5])], believed.covariances[k], atol=1e-18)
        assert not np.any(truth.pose.covariance)
        speeds = (truth.twist.twist.linear.x, truth.twist.twist.angular.z) if k else (0.25, 0.5)
        assert speeds == pytest.approx((0.25, 0.5), abs=1e-3)


def test_the_chain_of_frames_leads_to_the_truth(recorded: Any) -> None:
    run, found = recorded
    for (_, message), truth in zip(found["/tf"], run.truth, strict=True):
        names = [(link.header.frame_id, link.child_frame_id) for link in message.transforms]
        assert names == [("map", "odom"), ("odom", "base_link"), ("base_link", "laser")]
        T_map_odom, T_odom_base, T_base_laser = (
            planar(link.transform.translation, link.transform.rotation) for link in message.transforms
        )
        np.testing.assert_allclose(compose(compose(T_map_odom, T_odom_base), T_base_laser), truth, atol=1e-12)


def test_the_second_reader_agrees() -> None:
    decoder = pytest.importorskip("mcap_ros2.decoder")
    import io

    from mcap.reader import make_reader

    run = a_run()
    reader = make_reader(io.BytesIO(export_rosbag(run, START).mcap), decoder_factories=[decoder.DecoderFactory()])
    assert reader.get_header().profile == "ros2"
    seen = [message.ranges for _, _, _, message in reader.iter_decoded_messages(topics=["/scan"])]
    np.testing.assert_allclose(np.minimum(seen, 2.0), run.ranges, rtol=1e-6)


def test_what_ros_cannot_say_is_named() -> None:
    for argument, call in (
        ("run", lambda: export_rosbag(a_run(SimulatedLidar(np.array([0.0, 0.1, 0.3]), 2.0)))),
        ("run", lambda: export_rosbag(a_run(SimulatedLidar(np.array([]), 2.0)))),
        ("start_ns", lambda: export_rosbag(a_run(), 0)),
    ):
        with pytest.raises(RosbagError) as error:
            call()
        assert error.value.argument == argument
