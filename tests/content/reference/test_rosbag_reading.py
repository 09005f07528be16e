"""Bags read back and replayed: those that we write, and those of `rosbags`, which shares no code with the reader."""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Callable
from contextlib import closing, suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.formats.rosbag import export_rosbag
from reference.formats.rosbag_reading import BagReadingError, Recording, read_recording, read_rosbag

from .test_rosbag import START, a_run

RUN = a_run()


@cache
def mcap() -> bytes:
    return export_rosbag(RUN, START).mcap


def rewritten(folder: Path, plugin: str, keep: Callable[[str], bool] = lambda topic: True) -> dict[str, bytes]:
    """The same messages, of some topics, as `rosbags` stores them."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    Path(folder, "ours").mkdir()
    Path(folder, "ours", "run.mcap").write_bytes(mcap())
    Path(folder, "ours", "metadata.yaml").write_text(export_rosbag(RUN, START).metadata)
    with (
        rosbag2.Reader(folder / "ours") as reader,
        rosbag2.Writer(folder / "theirs", version=9, storage_plugin=rosbag2.StoragePlugin[plugin]) as writer,
    ):
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
        taken = {
            connection.id: writer.add_connection(connection.topic, connection.msgtype, typestore=store)
            for connection in reader.connections
            if keep(connection.topic)
        }
        for connection, time, data in reader.messages():
            if connection.id in taken:
                writer.write(taken[connection.id], time, data)
    return {file.name: file.read_bytes() for file in Path(folder, "theirs").iterdir()}


def assert_is_the_run(found: Recording) -> None:
    assert found.left_out == ()
    assert found.stamps_ns.tolist() == [START + round(1e9 * time) for time in RUN.times]
    np.testing.assert_allclose(found.T_odom_robot, RUN.odometry, atol=1e-12)
    np.testing.assert_allclose(found.T_robot_laser, 0.0, atol=1e-15)
    np.testing.assert_allclose([scan.ranges for scan in found.scans], RUN.ranges, rtol=1e-6)
    assert all(scan.measured.all() for scan in found.scans)
    np.testing.assert_allclose(found.scans[0].angles, RUN.lidar.angles, atol=1e-5)


def test_a_run_that_we_record_is_read_back() -> None:
    assert_is_the_run(read_recording({"run.mcap": mcap(), "metadata.yaml": b"anything"}))
    counts = Counter(message.topic for message in read_rosbag({"run.mcap": mcap()}))
    assert counts == export_rosbag(RUN, START).messages
    assert {m.topic for m in read_rosbag({"run.mcap": mcap()}, ["/odom", "/missing"])} == {"/odom"}


@pytest.mark.parametrize("plugin", ["SQLITE3", "MCAP"])
def test_bags_of_another_writer_are_read(tmp_path: Path, plugin: str) -> None:
    files = rewritten(tmp_path, plugin)
    assert any(name.endswith(".db3" if plugin == "SQLITE3" else ".mcap") for name in files)
    assert_is_the_run(read_recording(files))


def test_odometry_stands_in_for_frames_that_are_not_recorded(tmp_path: Path) -> None:
    """Nobody says then where the lidar is: the scan has to be in the robot's own frame."""
    files = rewritten(tmp_path, "SQLITE3", lambda topic: topic != "/tf")
    with pytest.raises(BagReadingError, match="'laser' was never published"):
        read_recording(files)
    assert_is_the_run(read_recording(with_frame(files, b"laser\0", b"base_link\0")))


def with_frame(files: dict[str, bytes], old: bytes, new: bytes) -> dict[str, bytes]:
    """The bag with another frame in the headers of its scans: CDR pads what follows a text to four bytes."""

    def rename(data: bytes) -> bytes:
        start = data.index(old) - 4
        padded = (len(old) + 3) // 4 * 4
        text = len(new).to_bytes(4, "little") + new + bytes(-len(new) % 4)
        return data[:start] + text + data[start + 4 + padded :]

    return edited(files, "/scan", rename)


def edited(files: dict[str, bytes], topic: str, change: Callable[[bytes], bytes]) -> dict[str, bytes]:
    """The sqlite3 bag with the data of a topic's messages changed."""
    name = next(name for name in files if name.endswith(".db3"))
    with closing(sqlite3.connect(":memory:")) as base:
        base.deserialize(files[name])
        rows = base.execute(
            "SELECT m.id, m.data FROM messages AS m JOIN topics AS t ON t.id = m.topic_id WHERE t.name = ?", (topic,)
        ).fetchall()
        base.executemany("UPDATE messages SET data = ? WHERE id = ?", [(change(data), rank) for rank, data in rows])
        base.commit()
        return files | {name: base.serialize()}


def test_files_of_a_split_bag_are_merged_by_date(tmp_path: Path) -> None:
    files = rewritten(tmp_path, "SQLITE3")
    name = next(name for name in files if name.endswith(".db3"))
    parts = {}
    for part, rest in (("a_1.db3", ">"), ("b_0.db3", "<=")):
        with closing(sqlite3.connect(":memory:")) as base:
            base.deserialize(files[name])
            base.execute(f"DELETE FROM messages WHERE timestamp {rest} ?", (START + round(1e9 * RUN.times[6]),))
            base.commit()
            parts[part] = base.serialize()
    assert_is_the_run(read_recording(parts))


def test_a_scan_between_two_transforms_is_placed_between_them_and_one_beyond_is_left_out(tmp_path: Path) -> None:
    """All scans dated half a period later: the last one is after all that odometry has said."""
    files = rewritten(tmp_path, "SQLITE3")
    half = round(5e8 * RUN.period)

    def later(data: bytes) -> bytes:
        seconds, nanoseconds = divmod(
            int.from_bytes(data[4:8], "little") * 10**9 + int.from_bytes(data[8:12], "little") + half, 10**9
        )
        return data[:4] + seconds.to_bytes(4, "little") + nanoseconds.to_bytes(4, "little") + data[12:]

    found = read_recording(edited(files, "/scan", later))
    assert len(found) == len(RUN) - 1
    assert len(found.left_out) == 1
    assert "after the last" in found.left_out[0]
    middle = (RUN.odometry[:-1] + RUN.odometry[1:]) / 2
    np.testing.assert_allclose(found.T_odom_robot, middle, atol=1e-9)


def test_dates_frames_and_angles_that_do_not_fit_are_named(tmp_path: Path) -> None:
    files = rewritten(tmp_path, "SQLITE3")
    name = next(name for name in files if name.endswith(".db3"))
    for argument, match, given_files in (
        ("files", "neither", {"metadata.yaml": b""}),
        ("run.mcap", "no MCAP", {"run.mcap": b"text"}),
        ("run.db3", "no sqlite3", {"run.db3": mcap()}),
        ("run.mcap", "cut short", {"run.mcap": mcap()[:5000]}),
        ("run.db3", "damaged", {"run.db3": files[name][:4096]}),
        ("run.db3.zstd", "unpack", {"run.db3.zstd": b""}),
        ("/scan", "cannot be read", edited(files, "/scan", lambda data: data[:40])),
        ("/scan", "angles do not fit", edited(files, "/scan", lambda data: data[:24] + b"\0\0\0\x40" + data[28:])),
        ("/tf", "quaternion of length", edited(files, "/tf", lambda data: data[:-32] + bytes(32))),
        ("scan_topic", "no topic", edited_type(files, name)),
    ):
        with pytest.raises(BagReadingError, match=match) as caught:
            read_recording(given_files)
        assert caught.value.argument == argument, match
    with pytest.raises(BagReadingError, match="/scan") as caught:
        read_recording(files, "/scan_filtered")
    assert caught.value.argument == "scan_topic"


def edited_type(files: dict[str, bytes], name: str) -> dict[str, bytes]:
    with closing(sqlite3.connect(":memory:")) as base:
        base.deserialize(files[name])
        base.execute("UPDATE topics SET type = 'my_robot/msg/Unknown' WHERE name = '/scan'")
        base.commit()
        return files | {name: base.serialize()}


@given(st.data())
@settings(max_examples=40)
def test_a_damaged_bag_is_refused_or_read_and_nothing_else(data: Any) -> None:
    content = bytearray(mcap())
    if data.draw(st.booleans()):
        del content[data.draw(st.integers(0, len(content) - 1)) :]
    else:
        for _ in range(3):
            content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    with suppress(BagReadingError):
        read_recording({"run.mcap": bytes(content)})
