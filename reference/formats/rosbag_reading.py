"""A rosbag2 read without ROS, from its files in memory: storage sqlite3 (.db3) and MCAP, messages in CDR.

`read_rosbag` gives the messages in the order of their recording. `read_recording` makes of them what SLAM starts from:
scans, each with the robot's odometry at its own date, and where the lidar sits on the robot.

Frames and dates are ROS's (REP 105): /tf and /tf_static fill a `FrameBuffer`; a bag without odom -> base_link there
gets it from its nav_msgs/Odometry. Dates of scans are those of their headers, not of their recording.

Sources: the storage plugins of rosbag2 (tables `topics` and `messages` of sqlite3) and the MCAP specification, which
the library `mcap` reads; sensor_msgs/LaserScan, REP 117.
"""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from heapq import merge
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.errors import InvalidArgumentError
from reference.formats.ros_definitions import DEFINITIONS
from reference.frames import NANOSECONDS, FrameBuffer, FrameError, Transform
from reference.world.scan import Scan

Floats = NDArray[np.float64]

SCAN, ODOMETRY, TF = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
SQLITE_MAGIC, MCAP_MAGIC = b"SQLite format 3\0", b"\x89MCAP0\r\n"
#: What a message that is cut short, or is none, makes of the decoder.
UNREADABLE = (struct.error, ValueError, IndexError, TypeError, OverflowError, MemoryError)


class BagReadingError(InvalidArgumentError):
    """Files that are no bag, or one that is damaged; `argument` names the file or the topic."""


@dataclass(frozen=True, eq=False)
class BagMessage:
    """One message: when it was recorded (ns), its topic and type, and its content, whose fields are attributes."""

    stamp_ns: int
    topic: str
    type_name: str
    content: Any


@dataclass(frozen=True, eq=False)
class Recording:
    """m scans of a bag in the order of their dates `stamps_ns` (m,), in nanoseconds.

    `T_odom_robot` (m, 3): the robot at the date of each scan; `T_robot_laser` (3,). `left_out`: scans that could not be
    placed, with the reason: at both ends of a bag odometry often begins late, or stops early.
    """

    scans: tuple[Scan, ...]
    stamps_ns: NDArray[np.int64]
    T_odom_robot: Floats
    T_robot_laser: Floats
    left_out: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.scans)


@dataclass(frozen=True)
class _RawMessage:
    """A message as it is stored: `rank` in its file, for messages of one date."""

    stamp_ns: int
    rank: int
    topic: str
    type_name: str
    definition: str
    data: bytes


def read_rosbag(files: Mapping[str, bytes], topics: Collection[str] | None = None) -> Iterator[BagMessage]:
    """The messages of a bag's `files`, name to content, of some `topics` or of all, in the order of their recording.

    Files of a split bag are merged; what is neither .db3 nor .mcap (metadata.yaml) is passed over. So are topics of
    types that are neither known here nor defined in the bag. Raises BagReadingError.
    """
    stores = [
        _iter_raw_messages(name, data, topics)
        for name, data in sorted(files.items())
        if name.endswith((".db3", ".mcap"))
    ]
    packed = next((name for name in sorted(files) if name.endswith((".zstd", ".zst"))), None)
    if packed is not None:
        raise BagReadingError(packed, "is packed as a whole: unpack it first (zstd -d)")
    if not stores:
        raise BagReadingError("files", "hold neither a .db3 nor a .mcap")
    decoders: dict[str, Callable[[bytes], Any]] = {}
    for raw in merge(*stores, key=lambda raw: (raw.stamp_ns, raw.rank)):
        if raw.type_name not in decoders:
            decoders[raw.type_name] = _make_decoder(raw)
        try:
            content = decoders[raw.type_name](raw.data)
        except UNREADABLE as fault:
            raise BagReadingError(
                raw.topic, f"holds a {raw.type_name} that cannot be read, recorded at {raw.stamp_ns} ns: {fault}"
            ) from fault
        yield BagMessage(raw.stamp_ns, raw.topic, raw.type_name, content)


def read_recording(
    files: Mapping[str, bytes], scan_topic: str | None = None, *, odom: str = "odom", robot: str = "base_link"
) -> Recording:
    """The scans of one topic, placed by odometry at their own dates. Where only one topic has scans, it needs no name.

    Raises BagReadingError: for a bag without scans or odometry, a lidar that moves on its robot, a scan whose angles
    do not fit its ranges.
    """
    messages = list(read_rosbag(files))
    topic = _choose_scan_topic(messages, scan_topic)
    frames = _build_frame_buffer(messages, odom, robot)
    placed: list[tuple[int, Scan, Floats, Floats]] = []
    left_out = []
    for message in (message for message in messages if message.topic == topic):
        stamp, frame = _stamp_nanoseconds(message.content.header), message.content.header.frame_id
        scan = _message_to_scan(message)
        try:
            T_odom_robot = frames.lookup(odom, robot, stamp).to_planar()
            T_robot_laser = frames.lookup(robot, frame, stamp).to_planar()
        except FrameError as fault:
            left_out.append(f"{topic}, {stamp} ns: {fault}")
            continue
        placed.append((stamp, scan, T_odom_robot, T_robot_laser))
    if not placed:
        raise BagReadingError(topic, f"has no scan that can be placed: {left_out[0]}")
    placed.sort(key=lambda row: row[0])
    mounts = np.array([T_robot_laser for _, _, _, T_robot_laser in placed])
    if np.ptp(mounts, axis=0).max() > 1e-6:
        raise BagReadingError(topic, f"is of a lidar that moves on {robot}")
    return Recording(
        tuple(scan for _, scan, _, _ in placed),
        np.array([stamp for stamp, _, _, _ in placed]),
        np.array([pose for _, _, pose, _ in placed]),
        mounts[0],
        tuple(left_out),
    )


def _choose_scan_topic(messages: list[BagMessage], wanted: str | None) -> str:
    found = sorted({message.topic for message in messages if message.type_name == SCAN})
    if wanted is not None:
        if wanted not in found:
            raise BagReadingError("scan_topic", f"{wanted!r} has no LaserScan; with some: {', '.join(found) or 'none'}")
        return wanted
    if len(found) != 1:
        raise BagReadingError("scan_topic", f"must be named: scans are on {', '.join(found) or 'no topic'}")
    return found[0]


def _build_frame_buffer(messages: list[BagMessage], odom: str, robot: str) -> FrameBuffer:
    """All transforms of a bag, however long it is; odometry's own where /tf has none of it."""
    span = messages[-1].stamp_ns - messages[0].stamp_ns
    frames = FrameBuffer(cache_ns=span + 3600 * NANOSECONDS)
    links: set[tuple[str, str]] = set()
    for message in (message for message in messages if message.type_name == TF):
        for link in message.content.transforms:
            names = link.header.frame_id.removeprefix("/"), link.child_frame_id.removeprefix("/")
            links.add(names)
            T = _message_to_transform(message, link.transform.translation, link.transform.rotation)
            frames.add(*names, T, _stamp_nanoseconds(link.header), static=message.topic.endswith("tf_static"))
    if (odom, robot) in links:
        return frames
    for message in (message for message in messages if message.type_name == ODOMETRY):
        content = message.content
        if (content.header.frame_id, content.child_frame_id) == (odom, robot):
            pose = content.pose.pose
            frames.add(
                odom,
                robot,
                _message_to_transform(message, pose.position, pose.orientation),
                _stamp_nanoseconds(content.header),
            )
    return frames


def _message_to_transform(message: BagMessage, translation: Any, rotation: Any) -> Transform:
    try:
        return Transform(
            np.array([translation.x, translation.y, translation.z]),
            np.array([rotation.x, rotation.y, rotation.z, rotation.w]),
        )
    except FrameError as fault:
        raise BagReadingError(message.topic, f"at {message.stamp_ns} ns: {fault}") from fault


def _message_to_scan(message: BagMessage) -> Scan:
    content = message.content
    ranges = np.asarray(content.ranges, dtype=np.float64)
    spread = (len(ranges) - 1) * content.angle_increment
    if not len(ranges) or abs(content.angle_min + spread - content.angle_max) > abs(content.angle_increment) + 1e-6:
        raise BagReadingError(
            message.topic, f"at {message.stamp_ns} ns has {len(ranges)} ranges, which its angles do not fit"
        )
    angles = content.angle_min + content.angle_increment * np.arange(len(ranges))
    try:
        return Scan.from_sensor(ranges, angles, content.range_max, max(content.range_min, 0.0))
    except InvalidArgumentError as fault:
        raise BagReadingError(message.topic, f"at {message.stamp_ns} ns: {fault}") from fault


def _stamp_nanoseconds(header: Any) -> int:
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


def _iter_raw_messages(name: str, data: bytes, topics: Collection[str] | None) -> Iterator[_RawMessage]:
    magic, read = (SQLITE_MAGIC, _iter_sqlite_messages) if name.endswith(".db3") else (MCAP_MAGIC, _iter_mcap_messages)
    if not data.startswith(magic):
        raise BagReadingError(name, f"is no {'sqlite3' if magic is SQLITE_MAGIC else 'MCAP'} file")
    return read(name, data, topics)


def _iter_sqlite_messages(name: str, data: bytes, topics: Collection[str] | None) -> Iterator[_RawMessage]:
    try:
        with closing(sqlite3.connect(":memory:")) as base:
            base.deserialize(data)
            tables = {table for (table,) in base.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
            own = (
                dict(base.execute("SELECT topic_type, encoded_message_definition FROM message_definitions"))
                if "message_definitions" in tables
                else {}
            )
            rows = base.execute(
                "SELECT m.timestamp, m.id, t.name, t.type, t.serialization_format, m.data FROM messages AS m"
                " JOIN topics AS t ON t.id = m.topic_id ORDER BY m.timestamp, m.id"
            )
            for stamp, rank, topic, type_name, form, content in rows:
                definition = DEFINITIONS.get(type_name) or own.get(type_name, "")
                if definition and form == "cdr" and (topics is None or topic in topics):
                    yield _RawMessage(stamp, rank, topic, type_name, definition, content)
    except sqlite3.DatabaseError as fault:
        raise BagReadingError(name, f"is damaged, or is no bag: {fault}") from fault


def _iter_mcap_messages(name: str, data: bytes, topics: Collection[str] | None) -> Iterator[_RawMessage]:
    from mcap.reader import make_reader  # slow to load, and seldom needed

    try:
        wanted = None if topics is None else list(topics)
        messages = make_reader(BytesIO(data), validate_crcs=True).iter_messages(wanted)
        for rank, (schema, channel, message) in enumerate(messages):
            if schema is not None and schema.encoding == "ros2msg" and channel.message_encoding == "cdr":
                yield _RawMessage(
                    message.log_time, rank, channel.topic, schema.name, schema.data.decode(), message.data
                )
    except Exception as fault:  # the library's own, those of two decompressors, and Python's
        why = str(fault) or type(fault).__name__
        raise BagReadingError(name, f"is damaged, or its recording was cut short: {why}") from fault


def _make_decoder(raw: _RawMessage) -> Callable[[bytes], Any]:
    from mcap.records import Schema
    from mcap_ros2.decoder import DecoderFactory

    schema = Schema(id=1, data=raw.definition.encode(), encoding="ros2msg", name=raw.type_name)
    try:
        found = DecoderFactory().decoder_for("cdr", schema)
    except Exception as fault:  # the parser of definitions has no error of its own
        raise BagReadingError(raw.topic, f"has a definition of {raw.type_name} that cannot be read: {fault}") from fault
    assert found is not None, "a schema of ros2msg has a decoder"
    return found
