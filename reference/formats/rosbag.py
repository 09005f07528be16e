"""A simulated run as a rosbag2, in memory: what a robot with ROS 2 would have recorded of it.

Topics: /scan (sensor_msgs/LaserScan), /odom and /ground_truth (nav_msgs/Odometry), /tf (tf2_msgs/TFMessage). Frames, by
REP 105: map -> odom -> base_link -> laser. /tf carries odom -> base_link, by odometry; base_link -> laser, the
identity; and, unless it is left for a SLAM to find, map -> odom, which is what a perfect localisation would publish,
T_map_odom = T_map_base (T_odom_base)^-1.

Sources: the interface definitions of ROS 2 (sensor_msgs, nav_msgs, tf2_msgs); REP 103 (units), 105 (frames), 117
(distances beyond the range are infinite); "Rosbag2 storage plugin mcap" and the bag metadata of rosbag2, version 5.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference import se2
from reference.errors import InvalidArgumentError
from reference.formats.ros_definitions import DEFINITIONS
from reference.odometry import dead_reckoning
from reference.world.simulation import SimulatedRun

Floats = NDArray[np.float64]
Message = dict[str, Any]

NANOSECONDS = 1_000_000_000
FILE_NAME = "run.mcap"
TOPICS = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/ground_truth": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
}
# Of (x, y, z, roll, pitch, yaw), those that move in the plane.
PLANAR = [0, 1, 5]


class RosbagError(InvalidArgumentError):
    """A run that the messages of ROS cannot tell; `argument` names what is at fault."""


@dataclass(frozen=True)
class Rosbag:
    """The files of a bag's folder: `mcap`, to be named `run.mcap`, and `metadata`, to be named `metadata.yaml`.

    `messages` counts those of each topic.
    """

    mcap: bytes
    metadata: str
    messages: dict[str, int]


def export_rosbag(run: SimulatedRun, start_ns: int = NANOSECONDS, *, localised: bool = True) -> Rosbag:
    """The bag of a run whose first pose was passed `start_ns` nanoseconds after the epoch.

    Without `localised`, /tf leaves out map -> odom, for who plays it beside a localisation of their own.

    Raises RosbagError for a run without poses or a lidar whose beams are not evenly spaced.
    """
    from mcap_ros2.writer import Writer  # slow to load, and seldom needed

    if not len(run):
        raise RosbagError("run", "holds no pose")
    if not 0 < start_ns < 2**31 * NANOSECONDS:
        raise RosbagError("start_ns", f"{start_ns} is not a time after the epoch that ROS can write")
    stamps = [start_ns + round(time * NANOSECONDS) for time in run.times.tolist()]
    output = BytesIO()
    writer: Any = Writer(output)
    schemas = {name: writer.register_msgdef(name, DEFINITIONS[name]) for name in sorted(set(TOPICS.values()))}
    counts = dict.fromkeys(TOPICS, 0)
    for stamp, topic, message in _iter_messages(run, stamps, localised):
        writer.write_message(topic, schemas[TOPICS[topic]], message, stamp, stamp, counts[topic])
        counts[topic] += 1
    writer.finish()
    return Rosbag(output.getvalue(), _make_metadata_yaml(stamps, counts), counts)


def _iter_messages(run: SimulatedRun, stamps: list[int], localised: bool) -> Iterator[tuple[int, str, Message]]:
    """What is said at each time, in the order of time."""
    spacing = _beam_spacing(run.lidar.angles)
    believed = dead_reckoning(run.drive, run.wheels, run.truth[0])
    corrections = se2.compose(run.truth, se2.inverse(believed.poses))
    sure = np.zeros((3, 3))
    for k, stamp in enumerate(stamps):
        correction = [_make_transform(stamp, "map", "odom", corrections[k])] if localised else []
        yield (
            stamp,
            "/tf",
            {
                "transforms": [
                    *correction,
                    _make_transform(stamp, "odom", "base_link", believed.poses[k]),
                    _make_transform(stamp, "base_link", "laser", np.zeros(3)),
                ]
            },
        )
        for topic, frame, poses, covariance in (
            ("/odom", "odom", believed.poses, believed.covariances[k]),
            ("/ground_truth", "map", run.truth, sure),
        ):
            yield stamp, topic, _make_odometry(stamp, frame, poses[k], covariance, _velocity_at(poses, k, run.period))
        yield stamp, "/scan", _make_laser_scan(stamp, run, k, spacing)


def _make_laser_scan(stamp: int, run: SimulatedRun, index: int, spacing: float) -> Message:
    angles, ranges = run.lidar.angles, run.ranges[index]
    return {
        "header": _make_header(stamp, "laser"),
        "angle_min": float(angles[0]),
        "angle_max": float(angles[-1]),
        "angle_increment": spacing,
        "time_increment": 0.0,
        "scan_time": run.period,
        "range_min": 0.0,
        "range_max": run.lidar.max_range,
        "ranges": np.where(ranges < run.lidar.max_range, ranges, np.inf).tolist(),
        "intensities": [],
    }


def _make_odometry(stamp: int, frame: str, pose: Floats, covariance: Floats, velocity: Floats) -> Message:
    position, orientation = _position_and_quaternion(pose)
    wide = np.zeros((6, 6))
    wide[np.ix_(PLANAR, PLANAR)] = covariance
    return {
        "header": _make_header(stamp, frame),
        "child_frame_id": "base_link",
        "pose": {
            "pose": {"position": position, "orientation": orientation},
            "covariance": wide.ravel().tolist(),
        },
        "twist": {
            "twist": {
                "linear": _make_vector(velocity[0], velocity[1]),
                "angular": {"x": 0.0, "y": 0.0, "z": float(velocity[2])},
            },
            "covariance": [0.0] * 36,
        },
    }


def _velocity_at(poses: Floats, index: int, period: float) -> Floats:
    """The twist (3,), in the robot's frame, that leads from the pose before to this one; zero at the first."""
    return se2.log(se2.relative(poses[index - 1], poses[index])) / period if index else np.zeros(3)


def _make_transform(stamp: int, parent: str, child: str, pose: Floats) -> Message:
    translation, rotation = _position_and_quaternion(pose)
    return {
        "header": _make_header(stamp, parent),
        "child_frame_id": child,
        "transform": {"translation": translation, "rotation": rotation},
    }


def _position_and_quaternion(pose: Floats) -> tuple[Message, Message]:
    """A pose (3,) of the plane as a position and a quaternion."""
    half = float(pose[2]) / 2.0
    return _make_vector(pose[0], pose[1]), {"x": 0.0, "y": 0.0, "z": float(np.sin(half)), "w": float(np.cos(half))}


def _make_vector(x: float, y: float) -> Message:
    return {"x": float(x), "y": float(y), "z": 0.0}


def _make_header(stamp: int, frame: str) -> Message:
    seconds, nanoseconds = divmod(stamp, NANOSECONDS)
    return {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": frame}


def _beam_spacing(angles: ArrayLike) -> float:
    """The angle between neighbouring beams, which a LaserScan says only once."""
    steps = np.diff(np.asarray(angles, dtype=np.float64))
    if not np.size(angles):
        raise RosbagError("run", "has a lidar without beams")
    if not steps.size:
        return 0.0
    if np.ptp(steps) > 1e-9:
        raise RosbagError("run", "has a lidar whose beams are not evenly spaced, which a LaserScan cannot say")
    return float(steps.mean())


def _make_metadata_yaml(stamps: list[int], counts: dict[str, int]) -> str:
    duration, total = stamps[-1] - stamps[0], sum(counts.values())
    topics = "".join(
        f"    - topic_metadata:\n        name: {topic}\n        type: {TOPICS[topic]}\n"
        f'        serialization_format: cdr\n        offered_qos_profiles: ""\n      message_count: {count}\n'
        for topic, count in counts.items()
    )
    span = (
        f"duration:\n{{0}}  nanoseconds: {duration}\n"
        f"{{0}}starting_time:\n{{0}}  nanoseconds_since_epoch: {stamps[0]}\n{{0}}message_count: {total}\n"
    )
    return (
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"
        f"  {span.format('  ')}"
        f"  topics_with_message_count:\n{topics}"
        '  compression_format: ""\n  compression_mode: ""\n'
        f"  relative_file_paths:\n    - {FILE_NAME}\n"
        f"  files:\n    - path: {FILE_NAME}\n      {span.format('      ')}"
    )
